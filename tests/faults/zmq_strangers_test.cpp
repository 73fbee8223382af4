#include <doctest/doctest.h>
#include <sys/resource.h>

#include <fstream>

#include "tests/faults/strangers.hpp"
#include "tests/faults/zmq_pair.hpp"

//! Strangers at the ports of a run: what they send gets nowhere, and what they hold stops nothing.
using namespace zmq_pair;
using namespace strangers;

namespace {

//! Of /proc/self/status, bytes.
long memory(std::string const& key)
{
    std::ifstream in("/proc/self/status");
    std::string word;
    long kilobytes = 0;
    while (in >> word)
        if (word == key + ":") in >> kilobytes;
    return kilobytes * 1024;
}

struct Way
{
    std::string name;
    std::function<Network(int port)> network;
};

//! The ways over tcp: secret of the run's directory, none (insecure), keys.
std::vector<Way> ways(in_threads::Scratch const& scratch, Keys const& keys)
{
    return {{"loopback", [&](int port) { return over_loopback(scratch, port); }},
            {"insecure", [](int port) { return with_hosts(port); }},
            {"curve", [&](int port) { return with_hosts(port, keys.scratch.path()); }}};
}

bool quiet(Transport& t)
{
    return !t.receive(milliseconds(100));
}

}  // namespace

TEST_CASE("Z4: 5000 connections that come and go stop neither a meeting nor a run")
{
    in_threads::Scratch scratch;
    Keys const keys;
    for (auto const& way : ways(scratch, keys)) {
        CAPTURE(way.name);
        int const port = ports::take();
        auto const a = member(0, way.network(port)), b = member(1, way.network(port));
        REQUIRE(greet(*a, *b));
        auto const before = memory("VmRSS");
        int const visits = way.name == "loopback" ? 5000 : 1000;
        for (int n = 0; n < visits; ++n) {
            throw_at(port_of_pair(port), "x");
            if (n % 500 == 0) CHECK(talk(*a, *b, 1));
        }
        CHECK(talk(*a, *b, 5));
        CHECK(memory("VmRSS") - before < 64'000'000);
        a->settle();
        b->settle();
        for (int n = 0; n < 3; ++n) CHECK(tcp::connect("127.0.0.1", port_of_pair(port)) == -1);  // shut for good
        CHECK(talk(*a, *b, 5));
        CHECK(!a->lost(1));
    }
}

TEST_CASE("Z4: strangers who stay connected hide no loss and cause none")
{
    in_threads::Scratch scratch;
    int const port = ports::take();
    auto const network = over_loopback(scratch, port);
    auto const a = member(0, network);
    std::vector<int> held;
    for (int n = 0; n < 50; ++n) held.push_back(tcp::connect("127.0.0.1", port_of_pair(port)));
    auto b = member(1, network);
    REQUIRE(greet(*a, *b));
    for (int n = 0; n < 50; ++n) held.push_back(tcp::connect("127.0.0.1", port_of_pair(port)));
    a->settle();
    b->settle();
    std::this_thread::sleep_for(milliseconds(400));
    for (int n = 0; n < 50; ++n) ::close(held[static_cast<std::size_t>(n)]);  // among them some that are not b's
    CHECK(talk(*a, *b, 3));
    CHECK(!a->lost(1));
    b.reset();
    CHECK(finds_lost(*a, 1));
    for (std::size_t n = 50; n < held.size(); ++n) ::close(held[n]);
}

TEST_CASE("Z4: strangers who hold more connections than there were descriptors stop nothing")
{
    rlimit usual = {};
    ::getrlimit(RLIMIT_NOFILE, &usual);
    if (usual.rlim_max < 2500) {
        MESSAGE("not tried: the hard limit of descriptors is " << usual.rlim_max);
        return;
    }
    in_threads::Scratch scratch;
    int const port = ports::take();
    int hears[2];
    REQUIRE(::pipe(hears) == 0);
    Child flood([&] {
        rlimit const many = {2500, usual.rlim_max};
        ::setrlimit(RLIMIT_NOFILE, &many);
        char go = 0;
        (void)!::read(hears[0], &go, 1);
        for (int n = 0; n < 2000; ++n) (void)tcp::connect("127.0.0.1", port_of_pair(port));
        ::pause();
    });
    rlimit const few = {256, usual.rlim_max};
    ::setrlimit(RLIMIT_NOFILE, &few);
    auto const network = over_loopback(scratch, port);
    auto const a = member(0, network);
    (void)!::write(hears[1], "x", 1);
    std::this_thread::sleep_for(seconds(1));
    auto const b = member(1, network);
    CHECK(meet(*a, *b));
    CHECK(talk(*a, *b, 10));
    CHECK(std::ifstream("/proc/self/status").good());  // a descriptor for others
    ::close(hears[0]);
    ::close(hears[1]);
    ::setrlimit(RLIMIT_NOFILE, &usual);
}

TEST_CASE("Z5: random bytes on the port become no message, before and during a run")
{
    in_threads::Scratch scratch;
    Keys const keys;
    std::mt19937 random(5);
    for (auto const& way : ways(scratch, keys)) {
        CAPTURE(way.name);
        int const port = ports::take();
        auto const a = member(0, way.network(port));
        for (int n = 0; n < 30; ++n) throw_at(port_of_pair(port), noise(random, 100'000));
        throw_at(port_of_pair(port), "GET / HTTP/1.1\r\nHost: x\r\n\r\n");
        throw_at(port_of_pair(port), std::string("\1\0\5hello", 8) + std::string("\5\0hello", 7));  // ZMTP/1.0
        CHECK(quiet(*a));
        auto const b = member(1, way.network(port));
        REQUIRE(greet(*a, *b));
        for (int n = 0; n < 30; ++n) throw_at(port_of_pair(port), noise(random, 100'000));
        CHECK(quiet(*a));
        CHECK(talk(*a, *b, 10));
        CHECK(!a->lost(1));
    }
}

TEST_CASE("Z6: a header that announces 4 GiB reserves nothing")
{
    in_threads::Scratch scratch;
    Keys const keys;
    for (auto const& way : ways(scratch, keys)) {
        CAPTURE(way.name);
        int const port = ports::take();
        auto network = way.network(port);
        network.largest_message = 1'000'000;
        auto const a = member(0, network);
        auto const before = memory("VmPeak");
        std::string const announced("\x02\0\0\0\1\0\0\0\0", 9);  // flags: long; 64 bits of length
        std::string const command("\x06\0\0\0\1\0\0\0\0", 9);
        for (int n = 0; n < 20; ++n)
            for (char const* mechanism : {"NULL", "PLAIN", "CURVE"}) {
                throw_at(port_of_pair(port), greeting(mechanism) + announced);
                throw_at(port_of_pair(port), greeting(mechanism) + command);
            }
        CHECK(quiet(*a));
        CHECK(memory("VmPeak") - before < 500'000'000);
        auto const b = member(1, network);
        CHECK(meet(*a, *b));
    }
}

TEST_CASE("a stranger who connects first does not hold the place of a peer, nor get a word in")
{
    in_threads::Scratch scratch;
    Keys const keys;
    for (auto const& way : ways(scratch, keys)) {
        CAPTURE(way.name);
        int const port = ports::take();
        auto const a = member(0, way.network(port));
        std::vector<std::unique_ptr<Stranger>> strangers;
        auto come = [&](std::function<void(void*)> const& options, int type = ZMQ_PAIR) {
            strangers.push_back(std::make_unique<Stranger>(port_of_pair(port), options, type));
            strangers.back()->send("let me in");
        };
        come([](void*) {});
        come([](void*) {}, ZMQ_DEALER);
        come(plain("sluice/1 b", "a guess"));
        come(plain("sluice/1 c", "insecure 1"));
        come(plain("sluice/2 b", "insecure 1"));
        come(curve(keys.open("a"), keys.pair("stranger")));
        come(curve(keys.open("stranger"), keys.pair("b")));
        CHECK(quiet(*a));
        std::this_thread::sleep_for(milliseconds(300));
        CHECK(quiet(*a));
        auto const b = member(1, way.network(port));
        REQUIRE(meet(*a, *b));
        CHECK(talk(*a, *b, 20));
        for (auto const& stranger : strangers) CHECK(!stranger->hears_anything());
        CHECK(!a->lost(1));
        CHECK(!b->lost(0));
    }
}

TEST_CASE("a stranger who holds the port first is not taken for the peer on loopback")
{
    in_threads::Scratch scratch;
    int const port = ports::take();
    auto const network = over_loopback(scratch, port);
    {
        Thief thief(port_of_pair(port));
        auto const b = member(1, network);
        for (int n = 0; n < 20; ++n) {
            CHECK(!b->try_send(0, suite::numbered(1, n, 10)));
            CHECK(!b->receive(milliseconds(20)));
            thief.welcome_everybody();
        }
        CHECK(thief.guests == 0);
        CHECK(b->trouble(0) == "it does not listen yet");
        CHECK_THROWS_AS((void)member(0, network), sluice::Error);  // and says who has the port: Z15
    }
    auto const a = member(0, network), b = member(1, network);
    CHECK(meet(*a, *b));
}

TEST_CASE("another run on the same port, and another version, are told apart")
{
    in_threads::Scratch one, two;
    int const port = ports::take();
    auto a = member(0, over_loopback(one, port));
    Stranger const newer(port_of_pair(port), plain("sluice/2 b", "x"));
    CHECK(within(patience, [&] { return !a->trouble(1).empty(); }));
    CHECK(a->trouble(1) == "a connection in its place was refused: it speaks sluice/2, this is sluice/1");
    Stranger const second_run(port_of_pair(port), plain("sluice/1 b", "the secret of another run"));
    CHECK(within(patience, [&] { return a->trouble(1).find("it belongs to another run") != std::string::npos; }));
    auto const d = sluice::make_zmq_transport({{"x", "y"}, 1}, with_hosts(port));
    CHECK(within(patience, [&] {
        (void)d->receive(milliseconds(10));
        return d->trouble(0) == "it belongs to another run or another version";
    }));
    a.reset();
    CHECK(within(patience, [&] {
        (void)d->receive(milliseconds(10));
        return d->trouble(0).find("connection refused") != std::string::npos;
    }));
}
