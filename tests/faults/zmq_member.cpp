#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>
#include <vector>

#include "coupler/base/error.hpp"
#include "coupler/transport/transport.hpp"

//! One of two members on two hosts: zmq_member SELF HOST0 HOST1 PORT KEYS SILENCE_MS ROUNDS PAUSE_MS, KEYS "-" for
//! none. In every round both send bytes that depend on all that came before; both end with "done HASH", the same one
//! each time. Exit 3: the peer was lost, and why; 4: it did not come within 20 s, and why.
namespace {

using sluice::Transport;
using std::chrono::milliseconds;

struct Lost
{};

void mix(std::uint64_t& hash, std::span<std::byte const> bytes)
{
    for (auto const b : bytes) hash = (hash ^ std::to_integer<std::uint64_t>(b)) * 0x100000001b3;  // FNV-1a
}

std::vector<std::byte> words(std::uint64_t hash, int self, int round)
{
    std::vector<std::byte> bytes(static_cast<std::size_t>(round) * 997 % 60'000 + 8);
    for (auto& b : bytes) {
        hash = hash * 6364136223846793005 + 1442695040888963407 + static_cast<std::uint64_t>(self);
        b = std::byte(hash >> 56);
    }
    return bytes;
}

void send(Transport& t, int peer, std::span<std::byte const> bytes)
{
    while (!t.try_send(peer, bytes)) {
        if (t.lost(peer)) throw Lost{};
        std::this_thread::sleep_for(milliseconds(1));
    }
}

Transport::Incoming receive(Transport& t, int peer)
{
    for (int empty = 0;;) {
        if (auto incoming = t.receive(milliseconds(50))) return std::move(*incoming);
        if (t.lost(peer) && ++empty > 1) throw Lost{};
    }
}

bool meet(Transport& t, int peer)
{
    auto const deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (!t.try_send(peer, std::as_bytes(std::span("hello", 5)))) {
        if (std::chrono::steady_clock::now() > deadline) return false;
        std::this_thread::sleep_for(milliseconds(5));
    }
    (void)receive(t, peer);
    t.settle();
    return true;
}

int converse(Transport& t, int self, int rounds, milliseconds pause)
{
    int const peer = 1 - self;
    if (!meet(t, peer)) {
        std::printf("did not come: %s\n", t.trouble(peer).c_str());
        return 4;
    }
    std::uint64_t hash = 0xcbf29ce484222325;
    for (int round = 0; round < rounds; ++round) {
        auto const mine = words(hash, self, round);
        send(t, peer, mine);
        auto const theirs = receive(t, peer);
        mix(hash, self == 0 ? std::span<std::byte const>(mine) : theirs.message.bytes);
        mix(hash, self == 0 ? theirs.message.bytes : std::span<std::byte const>(mine));
        std::this_thread::sleep_for(pause);
    }
    std::printf("done %016llx\n", static_cast<unsigned long long>(hash));
    std::fflush(stdout);
    try {  // whoever ends first is no loss to the other one
        send(t, peer, std::as_bytes(std::span("bye", 3)));
        (void)receive(t, peer);
    } catch (Lost const&) {
    }
    return 0;
}

}  // namespace

int main(int argc, char** argv)
{
    if (argc != 9) return 2;
    int const self = std::atoi(argv[1]);
    try {
        auto const t =
            sluice::make_zmq_transport({{"a", "b"}, self}, {.hosts = {argv[2], argv[3]},
                                                            .port = std::atoi(argv[4]),
                                                            .keys = std::string(argv[5]) == "-" ? "" : argv[5],
                                                            .silence = milliseconds(std::atoi(argv[6]))});
        try {
            return converse(*t, self, std::atoi(argv[7]), milliseconds(std::atoi(argv[8])));
        } catch (Lost const&) {
            std::printf("lost: %s\n", t->trouble(1 - self).c_str());
            return 3;
        }
    } catch (sluice::Error const& e) {
        std::printf("%s\n", e.what());
        return static_cast<int>(e.exit());
    }
}
