#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstring>
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

//! A pattern of 256 bytes, over and over: copied, since a sanitizer looks at every byte that a loop writes.
inline Bytes numbered(int sender, int number, std::size_t size)
{
    Bytes bytes(size);
    std::size_t const period = std::min<std::size_t>(size, 256);
    for (std::size_t i = 0; i < period; ++i)
        bytes[i] = std::byte((i * 31 + static_cast<std::size_t>(number) * 7 + static_cast<std::size_t>(sender)) & 0xff);
    for (std::size_t done = period; done < size; done *= 2)
        std::memcpy(bytes.data() + done, bytes.data(), std::min(done, size - done));
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
    auto const come = incoming.message.bytes;
    return come.size() == bytes.size() && (come.empty() || std::memcmp(come.data(), bytes.data(), come.size()) == 0);
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

//! 500 round trips.
inline void round_trips(Transport& t, int self)
{
    std::vector<Transport::Incoming> taken;
    for (int n = 0; n < 500; ++n) {
        if (self == 0) send(t, 1, numbered(0, n, 100), taken);
        expect(same(receive(t), numbered(1 - self, n, 100)), "round trip " + std::to_string(n));
        if (self == 1) send(t, 0, numbered(1, n, 100), taken);
    }
    expect(taken.empty(), "a message out of turn");
}

//! Messages that grow and shrink, 0 B to 8 MB, there and back.
inline void growing(Transport& t, int self)
{
    std::vector<Transport::Incoming> taken;
    int n = 0;
    for (std::size_t const size : {0, 1, 63, 64, 65, 4096, 100'000, 65'536, 3, 1'000'000, 0, 8'000'000, 70'000}) {
        if (self == 0) send(t, 1, numbered(0, ++n, size), taken);
        if (self == 1) ++n;
        expect(same(receive(t), numbered(1 - self, n, size)), std::to_string(size) + " B did not arrive as sent");
        if (self == 1) send(t, 0, numbered(1, n, size), taken);
    }
    expect(taken.empty(), "a message out of turn");
}

//! reserve() gives aligned memory; the last call counts; less may be sent than was reserved.
inline void reserved(Transport& t, int self)
{
    int const peer = 1 - self;
    auto room = [&](std::size_t size) {
        auto const deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
        for (;;) {
            auto const span = t.reserve(peer, size);
            if (span.data() && span.size() >= size) {
                expect(reinterpret_cast<std::uintptr_t>(span.data()) % 64 == 0, "reserve() is not aligned to 64 bytes");
                return span;
            }
            expect(std::chrono::steady_clock::now() < deadline, "no room within 20 s");
            expect(!t.receive(milliseconds(1)), "a message out of turn");
        }
    };
    for (std::size_t const size : {1, 1000, 300'000}) {
        if (self == 1) (void)receive(t);
        auto const first = room(2 * size);
        std::fill(first.begin(), first.end(), std::byte{0xaa});
        auto const bytes = numbered(self, 5, size);
        std::copy(bytes.begin(), bytes.end(), room(size + 100).begin());
        while (!t.commit(peer, size)) expect(!t.receive(milliseconds(1)), "a message out of turn");
        if (self == 0) expect(same(receive(t), numbered(1, 5, size)), "what was reserved did not arrive as filled");
    }
}

//! Messages are kept while hundreds of others come and go, and are let go in any order.
inline void kept(Transport& t, int self)
{
    constexpr int keep = 70, others = 200;
    int const peer = 1 - self;
    auto size = [](int n) { return static_cast<std::size_t>(n) * 700; };
    std::vector<Transport::Incoming> taken;
    for (int n = 0; n < keep + others; ++n) {
        if (self == 0) send(t, peer, numbered(0, n, size(n % keep)), taken);
        auto incoming = receive(t);
        expect(same(incoming, numbered(peer, n, size(n % keep))), "message " + std::to_string(n));
        if (n < keep) taken.push_back(std::move(incoming));
        if (self == 1) send(t, peer, numbered(1, n, size(n % keep)), taken);
    }
    for (int n : {7, 0, 69, 40, 1})
        expect(same(taken[static_cast<std::size_t>(n)], numbered(peer, n, size(n))), "a kept message has changed");
    for (std::size_t n = 0; n < taken.size(); n += 2) taken[n].message = {};
    for (std::size_t n = 1; n < taken.size(); n += 2)
        expect(same(taken[n], numbered(peer, static_cast<int>(n), size(static_cast<int>(n)))), "after others went");
}

//! A message ends a wait that has become a sleep.
inline void woken(Transport& t, int self)
{
    std::vector<Transport::Incoming> taken;
    for (int const nap : {0, 1, 5, 30, 120, 0, 400, 0, 2}) {
        if (self == 0) {
            std::this_thread::sleep_for(milliseconds(nap));
            send(t, 1, numbered(0, nap, 500), taken);
        }
        expect(same(receive(t), numbered(1 - self, nap, 500)), "after a nap of " + std::to_string(nap) + " ms");
        if (self == 1) send(t, 0, numbered(1, nap, 500), taken);
    }
}

//! A sender that is faster than its receiver may be refused, and loses nothing.
inline void flood(Transport& t, int self)
{
    constexpr int burst = 300;
    std::vector<Transport::Incoming> taken;
    if (self == 0) {
        int sent = 0;
        while (sent < burst && t.try_send(1, numbered(0, sent, 1000))) ++sent;
        send(t, 1, {}, taken);  // the end; the receiver has begun to read by then
        for (int n = 0; n < 3; ++n) send(t, 1, numbered(0, n, 2000), taken);
        expect(receive(t).message.bytes.size() == static_cast<std::size_t>(sent), "not all that was sent has come");
        return;
    }
    std::this_thread::sleep_for(milliseconds(200));
    int count = 0;
    for (auto next = receive(t); !next.message.bytes.empty(); next = receive(t), ++count)
        expect(same(next, numbered(0, count, 1000)), "message " + std::to_string(count) + " of a burst");
    for (int n = 0; n < 3; ++n) expect(same(receive(t), numbered(0, n, 2000)), "after a burst");
    send(t, 0, Bytes(static_cast<std::size_t>(count)), taken);
}

//! receive() with nothing under way returns after its patience, not before. Both sides are idle.
inline void patience(Transport& t, int /*self*/)
{
    for (auto const wait : {milliseconds(0), milliseconds(1), milliseconds(30), milliseconds(300)}) {
        auto const begin = std::chrono::steady_clock::now();
        expect(!t.receive(wait), "a message that nobody sent");
        auto const waited = std::chrono::steady_clock::now() - begin;
        expect(waited >= wait, "receive() did not wait");
        expect(waited < wait + std::chrono::seconds(10), "receive() waited for too long");  // generous: a busy machine
    }
}

//! For any number of members: each sends 60 messages to every other one; per pair they come in order.
inline void all_to_all(Transport& t, int self, int members)
{
    constexpr int each = 60;
    auto size = [](int n) { return static_cast<std::size_t>(n) * 1001 % 70'000; };
    auto number = [&](int from, int to, int n) { return (from * members + to) * each + n; };
    std::vector<Transport::Incoming> taken;
    for (int n = 0; n < each; ++n)
        for (int peer = 0; peer < members; ++peer)
            if (peer != self) send(t, peer, numbered(self, number(self, peer, n), size(n)), taken);
    auto const expected = static_cast<std::size_t>(each * (members - 1));
    std::vector<int> seen(static_cast<std::size_t>(members));
    while (taken.size() < expected) {
        auto incoming = t.receive(std::chrono::seconds(20));
        if (!incoming) {
            std::string came = "nothing more came to " + std::to_string(self) + " within 20 s; came:";
            for (auto const& m : taken) ++seen[static_cast<std::size_t>(m.peer)];
            for (int const n : seen) came += " " + std::to_string(n);
            throw std::runtime_error(came);
        }
        taken.push_back(std::move(*incoming));
    }
    for (auto const& message : taken) {
        int const n = seen.at(static_cast<std::size_t>(message.peer))++;
        expect(same(message, numbered(message.peer, number(message.peer, self, n), size(n))),
               "message " + std::to_string(n) + " from " + std::to_string(message.peer) + " is not what was sent");
    }
}

inline void all(Transport& t, int self)
{
    in_order(t, self);
    large(t, self);
    expect(!t.lost(1 - self), "a peer that is there counts as lost");
    round_trips(t, self);
    growing(t, self);
    reserved(t, self);
    kept(t, self);
    woken(t, self);
    flood(t, self);
    patience(t, self);
}

}  // namespace suite
