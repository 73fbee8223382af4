#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <random>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

//! TCP on loopback as strangers and bad networks use it.
namespace tcp {

inline sockaddr_in address(std::string const& host, int port)
{
    sockaddr_in a = {};
    a.sin_family = AF_INET;
    a.sin_port = htons(static_cast<std::uint16_t>(port));
    ::inet_pton(AF_INET, host.c_str(), &a.sin_addr);
    return a;
}

//! -1 if nobody accepts within 0.2 s.
inline int connect(std::string const& host, int port)
{
    int const s = ::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    auto const to = address(host, port);
    if (::connect(s, reinterpret_cast<sockaddr const*>(&to), sizeof to) == 0) return s;
    pollfd item{s, POLLOUT, 0};
    int error = 0;
    socklen_t size = sizeof error;
    if (::poll(&item, 1, 200) == 1 && ::getsockopt(s, SOL_SOCKET, SO_ERROR, &error, &size) == 0 && error == 0) return s;
    ::close(s);
    return -1;
}

//! Throws when the port is taken.
inline int listen(std::string const& host, int port)
{
    int const s = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    int const one = 1;
    ::setsockopt(s, SOL_SOCKET, SO_REUSEADDR, &one, sizeof one);
    auto const at = address(host, port);
    if (::bind(s, reinterpret_cast<sockaddr const*>(&at), sizeof at) != 0 || ::listen(s, 16) != 0)
        throw std::runtime_error("port " + std::to_string(port) + " is taken");
    return s;
}

//! Relays from one loopback address to another; what passes can be held back, delayed, changed or cut.
class Proxy
{
 public:
    using Clock = std::chrono::steady_clock;

    Proxy(std::string const& from, std::string to, int port)
        : to_(std::move(to)), port_(port), door_(listen(from, port))
    {
        thread_ = std::thread([this] { run(); });
    }
    Proxy(Proxy const&) = delete;
    Proxy& operator=(Proxy const&) = delete;
    ~Proxy()
    {
        stop_ = true;
        thread_.join();
        for (int s : sockets_) ::close(s);
        ::close(door_);
    }

    std::atomic<std::size_t> chunk{65'536};  //!< bytes that pass at once; fewer than that: every 5 ms
    std::atomic<int> delay{0}, jitter{0};    //!< ms; what is sent stays in order
    std::atomic<bool> hold{false};           //!< nothing passes; connections stay
    std::atomic<bool> hold_back{false};      //!< nothing passes back to who connected; connections stay
    std::atomic<bool> cut{false};            //!< connections are reset, once
    std::atomic<bool> cut_inside{false};     //!< the same, when a part of a message longer than a chunk has passed
    std::atomic<std::size_t> flip{0};        //!< one bit of the next message's first so many bytes, once
    std::atomic<int> connections{0};         //!< so far
    std::atomic<int> flips{0};               //!< so far

 private:
    struct Late  //!< bytes on their way; none: the end of the connection
    {
        int to;
        std::string bytes;
        Clock::time_point due;
    };

    void run()
    {
        while (!stop_) {
            if (cut.exchange(false)) reset_all();
            deliver_late();
            std::vector<pollfd> items{{door_, POLLIN, 0}};
            if (!hold)
                for (std::size_t i = 0; i < sockets_.size(); ++i)
                    items.push_back({hold_back && i % 2 == 1 ? -1 : sockets_[i], POLLIN, 0});
            if (::poll(items.data(), items.size(), late_.empty() ? 5 : 1) <= 0) continue;
            for (std::size_t i = 1; i < items.size(); ++i)
                if (items[i].revents != 0 && !relay(i - 1)) break;
            if (items[0].revents != 0 && !hold) accept_one();
        }
    }

    void accept_one()
    {
        int const in = ::accept4(door_, nullptr, nullptr, SOCK_CLOEXEC);
        int const out = connect(to_, port_);
        if (in < 0 || out < 0) {
            ::close(in);
            return;
        }
        ++connections;
        sockets_.insert(sockets_.end(), {in, out});
    }

    //! False: the pairs are not what they were.
    bool relay(std::size_t i)
    {
        char bytes[65536];
        if (chunk < sizeof bytes) std::this_thread::sleep_for(std::chrono::milliseconds(5));
        auto const n = ::recv(sockets_[i], bytes, std::min<std::size_t>(chunk, sizeof bytes), MSG_DONTWAIT);
        if (n < 0 && errno == EAGAIN) return true;
        int const to = sockets_[i ^ 1];
        std::string_view const came(bytes, n > 0 ? static_cast<std::size_t>(n) : 0);
        auto const begin = came.find("SLUC");  // wire/message.hpp
        if (flip > 0 && begin != came.npos) flip_one(bytes + begin, std::min(came.size() - begin, flip.exchange(0)));
        if (delay > 0 || !late_.empty()) {
            auto const wobble = jitter > 0 ? static_cast<int>(random_() % (2u * static_cast<unsigned>(jitter) + 1)) : 0;
            auto due = Clock::now() + std::chrono::milliseconds(delay - jitter + wobble);
            for (auto const& earlier : late_)
                if (earlier.to == to) due = std::max(due, earlier.due);
            if (n > 0 || !ending(to)) late_.push_back({to, std::string(came), due});
            if (n <= 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
            return true;
        }
        if (n <= 0) return close_pair(i);
        send_all(to, came);
        if (cut_inside && came.size() == sizeof bytes && begin == came.npos) {
            cut_inside = false;
            reset_all();
            return false;
        }
        return true;
    }

    bool ending(int to) const
    {
        return std::any_of(late_.begin(), late_.end(), [&](Late const& l) { return l.to == to && l.bytes.empty(); });
    }

    void deliver_late()
    {
        auto const now = Clock::now();
        for (std::size_t k = 0; k < late_.size();) {
            if (late_[k].due > now || hold) {
                ++k;
                continue;
            }
            auto const one = std::move(late_[k]);
            late_.erase(late_.begin() + static_cast<std::ptrdiff_t>(k));
            if (!one.bytes.empty()) {
                send_all(one.to, one.bytes);
                continue;
            }
            auto const found = std::find(sockets_.begin(), sockets_.end(), one.to);
            if (found != sockets_.end()) close_pair(static_cast<std::size_t>(found - sockets_.begin()));
            k = 0;
        }
    }

    void send_all(int to, std::string_view bytes)
    {
        for (std::size_t sent = 0; sent < bytes.size();) {
            auto const k = ::send(to, bytes.data() + sent, bytes.size() - sent, MSG_NOSIGNAL | MSG_DONTWAIT);
            if (k > 0)
                sent += static_cast<std::size_t>(k);
            else if (errno != EAGAIN || stop_)
                return;
            else
                std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
    }

    void flip_one(char* bytes, std::size_t size)
    {
        auto& byte = bytes[random_() % size];
        byte = static_cast<char>(byte ^ (1 << random_() % 8));
        ++flips;
    }

    bool close_pair(std::size_t i)
    {
        auto const pair = sockets_.begin() + static_cast<std::ptrdiff_t>(i & ~std::size_t{1});
        std::erase_if(late_, [&](Late const& l) { return l.to == pair[0] || l.to == pair[1]; });
        ::close(pair[0]);
        ::close(pair[1]);
        sockets_.erase(pair, pair + 2);
        return false;
    }

    void reset_all()
    {
        linger const at_once{1, 0};
        for (int s : sockets_) {
            ::setsockopt(s, SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
            ::close(s);
        }
        sockets_.clear();
        late_.clear();
    }

    std::string to_;
    int port_;
    int door_;
    std::vector<int> sockets_;  //!< 2k and 2k + 1 belong together; 2k is who connected
    std::vector<Late> late_;    //!< in the order in which they came
    std::mt19937 random_{12};
    std::atomic<bool> stop_{false};
    std::thread thread_;
};

}  // namespace tcp
