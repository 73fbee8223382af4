#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "coupler/transport/transport.hpp"

//! What every transport must do: each function is one side of a conversation between members 0 and 1 and throws
//! std::runtime_error at the first thing that is not as promised.
namespace suite {

using sluice::Transport;
using std::chrono::milliseconds;
using Bytes = std::vector<std::byte>;

inline Bytes numbered(int sender, int number, std::size_t size)
{
    Bytes bytes(size);
    for (std::size_t i = 0; i < size; ++i)
        bytes[i] = std::byte((i * 31 + static_cast<std::size_t>(number) * 7 + static_cast<std::size_t>(sender)) & 0xff);
    return bytes;
}

inline Transport::Incoming receive(Transport& t)
{
    auto const deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (std::chrono::steady_clock::now() < deadline)
        if (auto incoming = t.receive(milliseconds(100))) return std::move(*incoming);
    throw std::runtime_error("no message within 20 s");
}

inline bool same(Transport::Incoming const& incoming, Bytes const& bytes)
{
    return std::equal(incoming.message.bytes.begin(), incoming.message.bytes.end(), bytes.begin(), bytes.end());
}

inline void expect(bool ok, std::string const& what)
{
    if (!ok) throw std::runtime_error(what);
}

//! Sends, taking in what comes meanwhile, so that two sides that both send large messages do not block each other.
inline void send(Transport& t, int peer, Bytes const& bytes, std::vector<Transport::Incoming>& taken)
{
    while (!t.try_send(peer, bytes))
        if (auto incoming = t.receive(milliseconds(1))) taken.push_back(std::move(*incoming));
}

//! Both send 300 messages of 0 B to 200 kB at once; each must arrive whole, once and in order.
inline void in_order(Transport& t, int self)
{
    auto size = [](int n) { return static_cast<std::size_t>(n) * static_cast<std::size_t>(n) * 997 % 200'000; };
    int const peer = 1 - self;
    std::vector<Transport::Incoming> taken;
    for (int n = 0; n < 300; ++n) send(t, peer, numbered(self, n, size(n)), taken);
    while (taken.size() < 300) taken.push_back(receive(t));
    for (int n = 0; n < 300; ++n) {
        auto const& message = taken[static_cast<std::size_t>(n)];
        expect(message.peer == peer, "wrong sender");
        expect(same(message, numbered(peer, n, size(n))), "message " + std::to_string(n) + " is not what was sent");
    }
}

//! One message of 40 MB each way.
inline void large(Transport& t, int self)
{
    constexpr std::size_t size = 40'000'000;
    std::vector<Transport::Incoming> taken;
    send(t, 1 - self, numbered(self, 1, size), taken);
    if (taken.empty()) taken.push_back(receive(t));
    expect(same(taken[0], numbered(1 - self, 1, size)), "40 MB did not arrive as sent");
}

//! 500 round trips; receive() with nothing under way returns after its patience.
inline void round_trips(Transport& t, int self)
{
    std::vector<Transport::Incoming> taken;
    for (int n = 0; n < 500; ++n) {
        if (self == 0) send(t, 1, numbered(0, n, 100), taken);
        expect(same(receive(t), numbered(1 - self, n, 100)), "round trip " + std::to_string(n));
        if (self == 1) send(t, 0, numbered(1, n, 100), taken);
    }
    auto const begin = std::chrono::steady_clock::now();
    expect(!t.receive(milliseconds(30)), "a message that nobody sent");
    expect(std::chrono::steady_clock::now() - begin >= milliseconds(25), "receive() did not wait");
}

inline void all(Transport& t, int self)
{
    in_order(t, self);
    large(t, self);
    expect(!t.lost(1 - self), "a peer that is there counts as lost");
    round_trips(t, self);
}

}  // namespace suite
