#include "coupler/transport/zmq_doorman.hpp"

#include <algorithm>

#include "coupler/transport/zmq_door.hpp"
#include "coupler/transport/zmq_handle.hpp"

namespace sluice {
namespace {

//! What a connecting member calls itself; the number changes with what the two sides say before their first message.
constexpr char const* version = "sluice/1";

//! "water:1" is a process of "water" and uses its keys.
std::string participant_of(std::string const& member)
{
    return member.substr(0, member.find(':'));
}

//! In a time that does not tell where they differ.
bool equal(std::string const& a, std::string const& b)
{
    unsigned char difference = a.size() == b.size() ? 0 : 1;
    for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
        difference |= static_cast<unsigned char>(a[i] ^ b[i]);
    return difference == 0;
}

std::string common_word(std::vector<std::string> const& names)
{
    std::uint64_t hash = 0xcbf29ce484222325;  // FNV-1a: no secret, it tells runs apart
    for (auto const& name : names)
        for (unsigned char const c : name + "\n") hash = (hash ^ c) * 0x100000001b3;
    return "insecure " + std::to_string(hash);
}

}  // namespace

Doorman::Doorman(Members const& members, Network const& network) : names_(members.names), self_(members.self)
{
    if (!network.hosts.empty() && !network.keys.empty()) {
        own_ = read_key_pair(network.keys, participant_of(names_[static_cast<std::size_t>(self_)]));
        for (auto const& name : names_) public_keys_.push_back(read_public_key(network.keys, participant_of(name)));
    } else if (network.hosts.empty() && !network.directory.empty()) {
        word_ = run_secret(network.directory);
    } else {
        word_ = common_word(names_);
    }
}

void Doorman::protect(void* socket, int peer, bool listener) const
{
    if (listener) set_text(socket, ZMQ_ZAP_DOMAIN, std::to_string(peer));
    if (curve() && listener) {
        set_option(socket, ZMQ_CURVE_SERVER, 1);
        set_text(socket, ZMQ_CURVE_SECRETKEY, own_.secret);
    } else if (curve()) {
        set_text(socket, ZMQ_CURVE_SERVERKEY, public_keys_[static_cast<std::size_t>(peer)]);
        set_text(socket, ZMQ_CURVE_PUBLICKEY, own_.open);
        set_text(socket, ZMQ_CURVE_SECRETKEY, own_.secret);
    } else if (listener) {
        set_option(socket, ZMQ_PLAIN_SERVER, 1);
    } else {
        set_text(socket, ZMQ_PLAIN_USERNAME, std::string(version) + " " + names_[static_cast<std::size_t>(self_)]);
        set_text(socket, ZMQ_PLAIN_PASSWORD, word_);
    }
}

Doorman::Verdict Doorman::judge(Request const& request) const
{
    Verdict verdict;
    for (int p = 0; p < static_cast<int>(names_.size()); ++p)
        if (p != self_ && request.domain == std::to_string(p)) verdict.peer = p;
    if (verdict.peer < 0)
        verdict.refusal = "it came to a socket that is nobody's";
    else if (request.mechanism == (curve() ? "CURVE" : "PLAIN"))
        verdict.refusal = curve() ? judge_key(verdict.peer, request) : judge_word(verdict.peer, request);
    else
        verdict.refusal = "it uses other means of security than this run";
    return verdict;
}

std::string Doorman::judge_key(int peer, Request const& request) const
{
    if (request.credentials.size() != 1 || request.credentials[0].size() != 32) return "it showed no key";
    char text[41] = {};
    zmq_z85_encode(text, reinterpret_cast<unsigned char const*>(request.credentials[0].data()), 32);
    if (public_keys_[static_cast<std::size_t>(peer)] == text) return {};
    for (std::size_t p = 0; p < names_.size(); ++p)
        if (public_keys_[p] == text) return "it showed the key of \"" + names_[p] + "\"";
    return std::string("it showed the unknown key ") + text;
}

std::string Doorman::judge_word(int peer, Request const& request) const
{
    if (request.credentials.size() != 2) return "it did not say who it is";
    auto const& who = request.credentials[0];
    auto const& name = names_[static_cast<std::size_t>(peer)];
    bool const ours = who.starts_with("sluice/") && who.size() < 200 &&
                      std::all_of(who.begin(), who.end(), [](char c) { return c >= ' ' && c <= '~'; });
    if (!ours) return "it is none of ours";
    auto const space = std::min(who.find(' '), who.size());
    if (who.substr(0, space) != version) return "it speaks " + who.substr(0, space) + ", this is " + version;
    if (who.substr(space) != " " + name) return "it is \"" + who.substr(std::min(space + 1, who.size())) + "\"";
    if (!equal(request.credentials[1], word_)) return "it belongs to another run";
    return {};
}

}  // namespace sluice
