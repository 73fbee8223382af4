#include "coupler/transport/zmq_connection.hpp"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <zmq.h>

#include <algorithm>
#include <cstdio>
#include <fstream>

namespace sluice {
namespace {

constexpr std::chrono::milliseconds settling{300};  // events of the time before may still be on their way

std::uint64_t cookie_of(int descriptor)
{
    std::uint64_t cookie = 0;
    socklen_t size = sizeof cookie;
    return ::getsockopt(descriptor, SOL_SOCKET, SO_COOKIE, &cookie, &size) == 0 ? cookie : 0;
}

pid_t process_behind(int descriptor)
{
    ucred who = {};
    socklen_t size = sizeof who;
    return ::getsockopt(descriptor, SOL_SOCKET, SO_PEERCRED, &who, &size) == 0 ? who.pid : 0;
}

//! The letter of proc(5): R, S, T (stopped), Z (ended) ...; 0: there is no such process.
char state_of(pid_t process)
{
    std::ifstream in("/proc/" + std::to_string(process) + "/stat");
    std::string line;
    std::getline(in, line);
    auto const bracket = line.rfind(')');
    return bracket != std::string::npos && bracket + 2 < line.size() ? line[bracket + 2] : '\0';
}

std::string seconds(std::chrono::milliseconds time)
{
    char text[32];
    std::snprintf(text, sizeof text, "%.3g s", static_cast<double>(time.count()) * 1e-3);
    return text;
}

}  // namespace

void Connection::event(int number, int value)
{
    switch (number) {
        case ZMQ_EVENT_LISTENING:
            listening_ = value;
            break;
        case ZMQ_EVENT_CONNECTED:
        case ZMQ_EVENT_ACCEPTED:
            opened(value);
            break;
        case ZMQ_EVENT_HANDSHAKE_SUCCEEDED:
            if (open_.size() == 1) make_own(open_.begin()->first);  // else its first message tells which one it is
            break;
        case ZMQ_EVENT_DISCONNECTED:
            closed(value);
            break;
        case ZMQ_EVENT_CLOSED:  // there was nobody to connect with
            failed_attempt_ = !terms_.listener;
            reached_ = false;
            handshake_.clear();  // of a stranger who has gone
            break;
        default:  // a failed handshake; that its connection ends is told next
            if (terms_.listener) ++turned_away_;
            note_handshake(number, value);
    }
}

void Connection::opened(int descriptor)
{
    reached_ = true;
    gone_.erase(descriptor);
    open_[descriptor] = {terms_.tcp ? 0 : process_behind(descriptor), cookie_of(descriptor)};
    if (descriptor == early_) make_own(descriptor);
}

void Connection::closed(int descriptor)
{
    open_.erase(descriptor);
    gone_.insert(descriptor);
    if (descriptor == early_) early_ = -1;
    failed_attempt_ = !terms_.listener;
    if (descriptor != own_) return;
    own_ = -1;  // the number will be used again, perhaps by a stranger
    lost_ = true;
}

//! Before everybody has met a peer may be started again.
void Connection::make_own(int descriptor)
{
    if (lost_ && latched()) return;
    lost_ = silent_ = false;
    own_ = descriptor;
    early_ = -1;
    heard_ = Clock::now();
    handshake_.clear();
    refusal_.clear();
    if (auto const found = open_.find(descriptor); found != open_.end()) other_ = found->second;
}

void Connection::carried_message(int descriptor)
{
    if (descriptor < 0 || descriptor == own_) return;
    if (open_.contains(descriptor))
        make_own(descriptor);
    else if (!gone_.contains(descriptor))
        early_ = descriptor;  // its beginning is not known here yet
}

void Connection::refused(std::string const& why)
{
    refusal_ = "a connection in its place was refused: " + why;
}

void Connection::settle()
{
    settled_ = true;
    settled_at_ = Clock::now();
}

bool Connection::latched() const
{
    return settled_ && Clock::now() > settled_at_ + settling;
}

//! Every byte is a sign of life, also of a large message that takes long, and so is what is not taken in on this side.
void Connection::look()
{
    if (!terms_.tcp || !is_taken()) return;
    tcp_info info = {};
    socklen_t size = sizeof info;
    int waiting = 0;
    if (::getsockopt(own_, IPPROTO_TCP, TCP_INFO, &info, &size) != 0) return;
    auto const now = Clock::now();
    bool const unread = ::ioctl(own_, FIONREAD, &waiting) == 0 && waiting > 0;
    heard_ = std::max(heard_, unread ? now : now - std::chrono::milliseconds(info.tcpi_last_data_recv));
    if (now - heard_ > terms_.silence) hang_up_on_silent();
}

//! ZeroMQ then finds the connection ended, and so does the other side once it can be reached.
void Connection::hang_up_on_silent()
{
    if (cookie_of(own_) != other_.cookie) return;
    lost_ = silent_ = true;
    ::shutdown(own_, SHUT_RDWR);
}

std::string Connection::how_it_ended() const
{
    if (silent_) return "no heartbeat for " + seconds(terms_.silence);
    if (terms_.tcp) return "its connection ended";
    auto const process = "its process " + std::to_string(other_.process);
    char const state = other_.process > 0 ? state_of(other_.process) : 'S';
    if (state == '\0' || state == 'Z' || state == 'X') return process + " ended";
    if (state == 'T' || state == 't')
        return "no heartbeat for " + seconds(terms_.silence) + ": " + process + " is stopped";
    return "its connection ended, or no heartbeat for " + seconds(terms_.silence);
}

std::string Connection::handshake_trouble(int number, int value) const
{
    if (number == ZMQ_EVENT_HANDSHAKE_FAILED_AUTH && !terms_.listener) {
        if (value == 500) return "it is connected with another process in this one's place, or its run has begun";
        return terms_.curve ? "this one's key is not in its allow-list"
                            : "it belongs to another run or another version";
    }
    if (number == ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL) {
        if (value == ZMQ_PROTOCOL_ERROR_ZMTP_MECHANISM_MISMATCH)
            return terms_.curve ? "the other side uses no CURVE keys" : "the other side uses CURVE keys, this one none";
        if (value == ZMQ_PROTOCOL_ERROR_ZMTP_CRYPTOGRAPHIC)
            return terms_.listener ? "the other side has a wrong public key for this one"
                                   : "it has another key than here";
    }
    if (number == ZMQ_EVENT_HANDSHAKE_FAILED_NO_DETAIL && !terms_.listener)
        return terms_.curve ? "it broke off the handshake: its key is not the one known here, or it uses no CURVE keys"
                            : "it broke off the handshake: not a participant, or it uses CURVE keys and this one none";
    return {};
}

//! One side often knows more than the other, and not at every attempt.
void Connection::note_handshake(int number, int value)
{
    auto text = handshake_trouble(number, value);
    if (text.empty() || (number == ZMQ_EVENT_HANDSHAKE_FAILED_NO_DETAIL && !handshake_.empty())) return;
    handshake_ = std::move(text);
}

std::string Connection::trouble() const
{
    if (lost_) return how_it_ended();
    if (is_taken()) return {};
    if (!refusal_.empty()) return refusal_;
    if (!handshake_.empty()) return handshake_;
    if (turned_away_ > 0) return "connections that are none of ours were turned away: " + std::to_string(turned_away_);
    return {};
}

}  // namespace sluice
