#include <doctest/doctest.h>
#include <fcntl.h>
#include <sys/stat.h>

#include <fstream>
#include <set>

#include "tests/faults/zmq_pair.hpp"
#include "tests/support/tcp_proxy.hpp"

//! What ZeroMQ does by itself that a run must not suffer from: one test for each measured fact Z1, Z2, ...
//! Strangers, noise and keys (Z4 to Z6, Z16, Z17) are in zmq_strangers_test.cpp and zmq_keys_test.cpp, ends (Z13) in
//! zmq_ends_test.cpp.
using namespace zmq_pair;

namespace {

std::string error_of(std::function<void()> const& action, sluice::Exit expected)
{
    try {
        action();
    } catch (sluice::Error const& e) {
        CHECK(e.exit() == expected);
        return e.what();
    }
    return "(no error)";
}

bool has(std::string const& text, std::string const& part)
{
    INFO(text);
    CHECK(text.find(part) != std::string::npos);
    return text.find(part) != std::string::npos;
}

}  // namespace

TEST_CASE("Z1: a wait ends after its patience, and a killed peer is lost, over ipc and tcp")
{
    for (bool const ipc : {true, false}) {
        in_threads::Scratch scratch;
        auto const network = ipc ? over_ipc(scratch) : over_loopback(scratch, ports::take());
        Child b([&] { echo(network); });
        auto const a = member(0, network);
        REQUIRE(meet_child(*a));
        auto const begin = std::chrono::steady_clock::now();
        CHECK(!a->receive(milliseconds(50)));
        CHECK(std::chrono::steady_clock::now() - begin >= milliseconds(50));
        CHECK(!a->lost(1));
        auto const pid = std::to_string(b.pid());
        b.end(SIGKILL);
        CHECK(finds_lost(*a, 1));
        auto const why = ipc ? "its process " + pid + " ended" : "its connection ended";
        CHECK(within(patience, [&] { return a->trouble(1) == why; }));
    }
}

TEST_CASE("Z2: a stopped peer is lost for want of heartbeats, over ipc and tcp")
{
    for (bool const ipc : {true, false}) {
        in_threads::Scratch scratch;
        auto const network = ipc ? over_ipc(scratch) : over_loopback(scratch, ports::take());
        Child b([&] { echo(network); });
        auto const a = member(0, network);
        REQUIRE(meet_child(*a));
        b.signal(SIGSTOP);
        CHECK(finds_lost(*a, 1));
        has(a->trouble(1), "no heartbeat for 1.5 s");
        if (ipc) has(a->trouble(1), "is stopped");
    }
}

TEST_CASE("Z3: a peer that computes for longer than the silence allowed is not lost")
{
    in_threads::Scratch scratch;
    auto const network = over_loopback(scratch, ports::take());
    auto const a = member(0, network), b = member(1, network);
    REQUIRE(meet(*a, *b));
    std::this_thread::sleep_for(2 * silence);  // nobody calls; ZeroMQ's own thread answers
    CHECK(!a->lost(1));
    CHECK(!b->lost(0));
    CHECK(talk(*a, *b, 10));
}

TEST_CASE("Z7: a message larger than agreed is refused by its sender")
{
    in_threads::Scratch scratch;
    auto network = over_ipc(scratch);
    network.largest_message = 1000;
    auto const a = member(0, network), b = member(1, network);
    REQUIRE(meet(*a, *b));
    has(error_of([&] { (void)a->try_send(1, suite::numbered(0, 1, 1001)); }, sluice::Exit::io),
        "1001 bytes (at most 1000");
    CHECK(say(*a, 1, std::string(1000, 'x')));
    CHECK(text_from(*b) == std::string(1000, 'x'));
}

TEST_CASE("Z7: a message larger than the receiver takes is a loss at both ends, never a silent gap")
{
    in_threads::Scratch scratch;
    auto narrow = over_ipc(scratch), wide = narrow;
    narrow.largest_message = 1000;
    auto const a = member(0, narrow), b = member(1, wide);
    REQUIRE(meet(*a, *b));
    REQUIRE(say(*b, 0, std::string(2000, 'x')));
    (void)say(*b, 0, "after");
    CHECK(finds_lost(*a, 1));
    CHECK(finds_lost(*b, 0));
    CHECK(!a->receive(milliseconds(300)));  // and nothing that was sent after it arrives
}

TEST_CASE("Z8: after a partition longer than the silence both sides find the other lost, for good")
{
    Apart apart;
    auto& [port, proxy, a, b] = apart;
    REQUIRE(meet(*a, *b));
    REQUIRE(talk(*a, *b, 10));
    proxy.hold = true;
    int const before = proxy.connections;
    for (int n = 0; n < 5; ++n) (void)b->try_send(0, suite::numbered(1, n, 100));
    CHECK(finds_lost(*a, 1));
    CHECK(finds_lost(*b, 0));
    has(a->trouble(1), "no heartbeat for 1.5 s");
    has(b->trouble(0), "no heartbeat for 1.5 s");
    proxy.hold = false;
    std::this_thread::sleep_for(milliseconds(500));
    for (int n = 0; n < 20; ++n) {  // neither comes back behind the gap
        CHECK(!a->receive(milliseconds(10)));
        CHECK(!b->receive(milliseconds(10)));
    }
    CHECK(a->lost(1));
    CHECK(b->lost(0));
    CHECK(proxy.connections == before);
}

TEST_CASE("Z9: a partition shorter than the silence loses nothing")
{
    Apart apart;
    auto& [port, proxy, a, b] = apart;
    REQUIRE(meet(*a, *b));
    proxy.hold = true;
    for (int n = 0; n < 10; ++n) REQUIRE(say(*b, 0, "held " + std::to_string(n)));
    std::this_thread::sleep_for(silence / 2);
    proxy.hold = false;
    for (int n = 0; n < 10; ++n) CHECK(text_from(*a) == "held " + std::to_string(n));
    CHECK(talk(*a, *b, 10));
    CHECK(!a->lost(1));
}

TEST_CASE("Z9: a message that takes longer than the silence is no loss")
{
    Apart apart;
    auto& [port, proxy, a, b] = apart;
    REQUIRE(meet(*a, *b));
    proxy.chunk = 20'000;  // 4 MB/s at most
    auto const message = suite::numbered(1, 1, 20'000'000);
    REQUIRE(b->try_send(0, message));
    auto const begin = std::chrono::steady_clock::now();
    std::optional<Transport::Incoming> incoming;
    while (!incoming && !a->lost(1) && std::chrono::steady_clock::now() - begin < 3 * patience)
        incoming = a->receive(milliseconds(100));
    CHECK(std::chrono::steady_clock::now() - begin > silence);  // else this tries nothing
    CHECK(!a->lost(1));
    CHECK(!b->lost(0));
    REQUIRE(incoming);
    CHECK(suite::same(*incoming, message));
}

TEST_CASE("Z9: a peer that computes while its queue is full is no loss over tcp")
{
    in_threads::Scratch scratch;
    auto const network = over_loopback(scratch, ports::take());
    auto const a = member(0, network), b = member(1, network);
    REQUIRE(meet(*a, *b));
    auto const message = suite::numbered(1, 1, 200'000);
    int sent = 0;
    while (within(milliseconds(300), [&] { return b->try_send(0, message); })) ++sent;
    std::this_thread::sleep_for(2 * silence);
    REQUIRE(!b->lost(0));
    REQUIRE(!a->lost(1));
    for (int n = 0; n < sent; ++n) REQUIRE(suite::same(suite::receive(*a), message));
    CHECK(talk(*a, *b, 5));
}

TEST_CASE("Z9: a connection that is reset is a loss at both ends")
{
    Apart apart;
    auto& [port, proxy, a, b] = apart;
    REQUIRE(meet(*a, *b));
    proxy.cut = true;
    CHECK(finds_lost(*a, 1));
    CHECK(finds_lost(*b, 0));
    CHECK(a->trouble(1) == "its connection ended");
}

TEST_CASE("Z10: a second process in a member's place is refused and told, the first goes on")
{
    in_threads::Scratch scratch;
    auto const network = over_ipc(scratch);
    auto const a = member(0, network), b = member(1, network);
    REQUIRE(greet(*a, *b));
    for (int self : {0, 1}) {
        auto const text = error_of([&] { (void)member(self, network); }, sluice::Exit::protocol);
        has(text, self == 0 ? "\"a\" is already here: process " : "\"b\" is already here: process ");
        has(text, std::to_string(::getpid()));
    }
    CHECK(talk(*a, *b, 20));
}

TEST_CASE("Z10: a second process on another host, where no file is shared, is refused and told")
{
    int const port = ports::take();
    auto const a = member(0, with_hosts(port)), b = member(1, with_hosts(port));
    REQUIRE(greet(*a, *b));
    auto const twin = member(1, with_hosts(port));
    CHECK(within(patience, [&] {
        (void)twin->receive(milliseconds(10));
        return twin->trouble(0).find("another process in this one's place") != std::string::npos;
    }));
    CHECK(!twin->try_send(0, suite::numbered(1, 1, 10)));
    CHECK(talk(*a, *b, 20));
}

TEST_CASE("Z11: a peer may start again before all have met, not after")
{
    int const port = ports::take();
    auto const network = with_hosts(port);
    auto const a = member(0, network);
    {
        auto const first = member(1, network);
        REQUIRE(greet(*a, *first));
    }
    CHECK(finds_lost(*a, 1));
    auto second = member(1, network);
    REQUIRE(meet(*a, *second));
    CHECK(!a->lost(1));
    std::this_thread::sleep_for(milliseconds(400));
    second.reset();
    CHECK(finds_lost(*a, 1));
    auto const third = member(1, network);
    for (int n = 0; n < 50; ++n) {
        CHECK(!third->try_send(0, suite::numbered(1, n, 10)));
        CHECK(!a->receive(milliseconds(10)));
    }
    CHECK(a->lost(1));
}

TEST_CASE("Z11: a listener may start again before all have met")
{
    in_threads::Scratch scratch;
    auto const network = over_loopback(scratch, ports::take());
    auto a = member(0, network);
    auto const b = member(1, network);
    REQUIRE(greet(*a, *b));
    a.reset();
    CHECK(finds_lost(*b, 0));
    a = member(0, network);
    REQUIRE(meet(*a, *b));
    CHECK(!b->lost(0));
    CHECK(talk(*a, *b, 10));
}

TEST_CASE("Z12: nothing is sent to a peer that is not there")
{
    in_threads::Scratch scratch;
    auto const network = over_ipc(scratch);
    auto const b = member(1, network);
    auto const message = suite::numbered(1, 7, 100);
    for (int n = 0; n < 20; ++n) CHECK(!b->try_send(0, message));
    CHECK(b->trouble(0) == "it does not listen yet");
    auto const a = member(0, network);
    REQUIRE(within(patience, [&] { return b->try_send(0, message); }));
    auto const incoming = suite::receive(*a);
    CHECK(suite::same(incoming, message));
}

TEST_CASE("Z14: a socket file that a killed process left behind is no obstacle")
{
    in_threads::Scratch scratch;
    auto const network = over_ipc(scratch);
    {
        Child dead([&] {
            auto const a = member(0, network);
            for (;;) ::pause();
        });
        REQUIRE(within(patience, [&] { return std::filesystem::exists(scratch.path() / "0-1"); }));
        dead.end(SIGKILL);
    }
    REQUIRE(std::filesystem::exists(scratch.path() / "0-1"));
    auto const a = member(0, network), b = member(1, network);
    REQUIRE(meet(*a, *b));
}

TEST_CASE("Z14: a directory that others can enter, and a path that is too long, are refused")
{
    in_threads::Scratch scratch;
    ::chmod(scratch.path().c_str(), 0755);
    has(error_of([&] { (void)member(0, over_ipc(scratch)); }, sluice::Exit::security), "only this user can enter");
    ::chmod(scratch.path().c_str(), 0700);
    auto const deep = scratch.path() / std::string(100, 'x');
    std::filesystem::create_directory(deep);
    ::chmod(deep.c_str(), 0700);
    has(error_of([&] { (void)member(0, {.directory = deep}); }, sluice::Exit::io), "(at most 107)");
}

TEST_CASE("Z15: a taken port is named with its owner")
{
    in_threads::Scratch scratch;
    int const port = ports::take();
    int const taken = tcp::listen("127.0.0.1", port_of_pair(port));
    auto const text = error_of([&] { (void)member(0, over_loopback(scratch, port)); }, sluice::Exit::io);
    ::close(taken);
    has(text, "port " + std::to_string(port_of_pair(port)) + " is taken by process " + std::to_string(::getpid()));
    has(text, "(faults_zmq)");
}

TEST_CASE("hosts: an address of another machine, an unknown name and a name for loopback are said to be that")
{
    auto network = with_hosts(ports::take());
    network.hosts = {"192.0.2.1", "192.0.2.2"};  // TEST-NET-1: nobody's
    has(error_of([&] { (void)member(0, network); }, sluice::Exit::io),
        "host 192.0.2.1 is not an address of this machine");
    network.hosts = {"no-such-host.invalid", "192.0.2.2"};
    has(error_of([&] { (void)member(0, network); }, sluice::Exit::config), "host no-such-host.invalid: ");
    network.hosts = {"localhost", "192.0.2.2"};
    has(error_of([&] { (void)member(0, network); }, sluice::Exit::config),
        "this host's loopback: \"b\" on 192.0.2.2 cannot");
}

TEST_CASE("hosts: a name and IPv6 work, a host where nobody listens refuses")
{
    for (std::string const host : {"localhost", "::1"}) {
        auto network = with_hosts(ports::take());
        network.hosts = {host, host};
        auto const b = member(1, network);
        CHECK(within(patience, [&] {
            (void)b->receive(milliseconds(10));
            return b->trouble(0).find("connection refused") != std::string::npos;
        }));
        auto const a = member(0, network);
        CHECK(meet(*a, *b));
        CHECK(talk(*a, *b, 3));
    }
}

TEST_CASE("S6: a member holds at most 4 descriptors for each peer")
{
    auto descriptors = [] {
        return std::distance(std::filesystem::directory_iterator("/proc/self/fd"),
                             std::filesystem::directory_iterator{});
    };
    auto held_by = [&](int count) {
        in_threads::Scratch scratch;
        std::vector<std::string> names;
        for (int p = 0; p < count; ++p) names.push_back("m" + std::to_string(p));
        auto const network = over_loopback(scratch, ports::take(count * count));
        auto const before = descriptors();
        std::vector<Owner> all;
        for (int p = 0; p < count; ++p) all.push_back(sluice::make_zmq_transport({names, p}, network));
        std::vector<char> said(static_cast<std::size_t>(count * count));
        CHECK(within(patience, [&] {
            int missing = 0;
            for (int p = 0; p < count; ++p)
                for (int q = 0; q < count; ++q)
                    if (auto& done = said[static_cast<std::size_t>(p * count + q)]; p != q && !done) {
                        done = all[static_cast<std::size_t>(p)]->try_send(q, suite::numbered(p, q, 10));
                        missing += !done;
                    }
            if (missing > 0) std::this_thread::sleep_for(milliseconds(5));
            return missing == 0;
        }));
        return descriptors() - before;
    };
    auto const four = held_by(4), eight = held_by(8);
    double const constant = (static_cast<double>(four) / 4 * 7 - static_cast<double>(eight) / 8 * 3) / 4;
    double const per_peer = (static_cast<double>(eight) / 8 - static_cast<double>(four) / 4) / 4;
    MESSAGE("descriptors of one member: " << constant << " and " << per_peer << " for each peer");
    CHECK(per_peer <= 4.0);
    CHECK(constant <= 20.0);
}

TEST_CASE("several peers: a token that goes round among messages to everybody is never slept over")
{
    constexpr int count = 4, rounds = 500;
    in_threads::Scratch scratch;
    auto const network = over_ipc(scratch);
    std::vector<std::string> names;
    for (int p = 0; p < count; ++p) names.push_back("m" + std::to_string(p));
    std::vector<std::string> wrong(count);
    auto body = [&](int self) {
        auto const t = sluice::make_zmq_transport({names, self}, network);
        std::set<std::string> come;
        auto tell_all = [&](std::string const& number) {
            for (int p = 0; p < count; ++p)
                if (p != self && !say(*t, p, number)) throw std::runtime_error("no way to a peer");
        };
        for (int n = 0; n < rounds; ++n) {
            if (n % count == self) tell_all(std::to_string(n));               // all others wait for it
            while (n % count != self && !come.contains(std::to_string(n))) {  // two senders have no order
                auto const incoming = t->receive(patience);  // one long sleep: a missed signal would end the test
                if (!incoming) throw std::runtime_error("nothing in round " + std::to_string(n));
                come.emplace(reinterpret_cast<char const*>(incoming->message.bytes.data()),
                             incoming->message.bytes.size());
            }
            if (n == count) t->settle();
        }
        tell_all("bye " + std::to_string(self));
        for (int p = 0; p < count; ++p)
            while (p != self && !t->lost(p) && !come.contains("bye " + std::to_string(p)))
                if (auto const incoming = t->receive(milliseconds(100)))
                    come.emplace(reinterpret_cast<char const*>(incoming->message.bytes.data()),
                                 incoming->message.bytes.size());
    };
    std::vector<std::thread> threads;
    for (int p = 0; p < count; ++p)
        threads.emplace_back([&, p] {
            try {
                body(p);
            } catch (std::exception const& e) {
                wrong[static_cast<std::size_t>(p)] = e.what();
            }
        });
    for (auto& thread : threads) thread.join();
    for (auto const& text : wrong) CHECK(text == "");
}

TEST_CASE("HWM: a slow reader bounds what a fast sender queues, and loses nothing")
{
    in_threads::Scratch scratch;
    auto const network = over_ipc(scratch);
    auto const a = member(0, network), b = member(1, network);
    REQUIRE(meet(*a, *b));
    int sent = 0;
    while (sent < 1000 && within(milliseconds(200), [&] { return a->try_send(1, suite::numbered(0, sent, 100'000)); }))
        ++sent;
    CHECK(sent < 300);  // 64 at each end and what the kernel holds
    for (int n = 0; n < sent; ++n) CHECK(suite::same(suite::receive(*b), suite::numbered(0, n, 100'000)));
    CHECK(talk(*a, *b, 3));
}
