#include <doctest/doctest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <zmq.h>

#include <algorithm>
#include <fstream>
#include <random>

#include "coupler/transport/keys.hpp"
#include "tests/faults/zmq_pair.hpp"
#include "tests/support/tcp_proxy.hpp"

//! Strangers at the ports of a run: what they send gets nowhere, and what they hold stops nothing.
using namespace zmq_pair;

namespace {

//! A ZeroMQ socket of somebody else's that connects to a listener, with or without security of its own.
class Stranger
{
 public:
    explicit Stranger(
        int port, std::function<void(void*)> const& options = [](void*) {}, int type = ZMQ_PAIR)
        : context_(zmq_ctx_new()), socket_(zmq_socket(context_, type))
    {
        int const zero = 0;
        zmq_setsockopt(socket_, ZMQ_LINGER, &zero, sizeof zero);
        options(socket_);
        zmq_connect(socket_, ("tcp://127.0.0.1:" + std::to_string(port)).c_str());
    }
    Stranger(Stranger const&) = delete;
    Stranger& operator=(Stranger const&) = delete;
    ~Stranger()
    {
        zmq_close(socket_);
        zmq_ctx_term(context_);
    }
    void send(std::string const& text) const { zmq_send(socket_, text.data(), text.size(), ZMQ_DONTWAIT); }
    bool hears_anything() const
    {
        char byte = 0;
        return zmq_recv(socket_, &byte, 1, ZMQ_DONTWAIT) >= 0;
    }

 private:
    void* context_;
    void* socket_;
};

//! Listens in a member's place, lets everybody in and speaks to them.
class Thief
{
 public:
    explicit Thief(int port)
        : context_(zmq_ctx_new()), requests_(zmq_socket(context_, ZMQ_REP)), socket_(zmq_socket(context_, ZMQ_PAIR))
    {
        int const zero = 0, one = 1;
        zmq_bind(requests_, "inproc://zeromq.zap.01");
        zmq_setsockopt(socket_, ZMQ_LINGER, &zero, sizeof zero);
        zmq_setsockopt(socket_, ZMQ_PLAIN_SERVER, &one, sizeof one);
        zmq_setsockopt(socket_, ZMQ_ZAP_DOMAIN, "x", 1);
        REQUIRE(zmq_bind(socket_, ("tcp://127.0.0.1:" + std::to_string(port)).c_str()) == 0);
    }
    Thief(Thief const&) = delete;
    Thief& operator=(Thief const&) = delete;
    ~Thief()
    {
        zmq_close(socket_);
        zmq_close(requests_);
        zmq_ctx_term(context_);
    }
    void welcome_everybody()
    {
        char part[300];
        if (zmq_recv(requests_, part, sizeof part, ZMQ_DONTWAIT) >= 0) {
            ++guests;
            int more = 1;
            for (std::size_t size = sizeof more; more != 0; zmq_getsockopt(requests_, ZMQ_RCVMORE, &more, &size))
                zmq_recv(requests_, part, sizeof part, ZMQ_DONTWAIT);
            for (std::string const word : {"1.0", "1", "200", "", ""})
                zmq_send(requests_, word.data(), word.size(), ZMQ_SNDMORE);
            zmq_send(requests_, "", 0, 0);
        }
        zmq_send(socket_, "I am a", 6, ZMQ_DONTWAIT);
    }
    int guests = 0;

 private:
    void* context_;
    void* requests_;
    void* socket_;
};

std::function<void(void*)> plain(std::string const& name, std::string const& word)
{
    return [=](void* s) {
        zmq_setsockopt(s, ZMQ_PLAIN_USERNAME, name.data(), name.size());
        zmq_setsockopt(s, ZMQ_PLAIN_PASSWORD, word.data(), word.size());
    };
}

std::function<void(void*)> curve(std::string const& server, sluice::KeyPair const& own)
{
    return [=](void* s) {
        zmq_setsockopt(s, ZMQ_CURVE_SERVERKEY, server.data(), 40);
        zmq_setsockopt(s, ZMQ_CURVE_PUBLICKEY, own.open.data(), 40);
        zmq_setsockopt(s, ZMQ_CURVE_SECRETKEY, own.secret.data(), 40);
    };
}

//! A directory with keys for "a" and "b", and for "stranger", who is none of the run.
struct Keys
{
    Keys()
    {
        for (char const* name : {"a", "b", "stranger"}) sluice::make_key_pair(scratch.path(), name);
    }
    std::string open(char const* name) const { return sluice::read_public_key(scratch.path(), name); }
    sluice::KeyPair pair(char const* name) const { return sluice::read_key_pair(scratch.path(), name); }
    in_threads::Scratch scratch;
};

std::string noise(std::mt19937& random, std::size_t size)
{
    std::string bytes(size, '\0');
    std::generate(bytes.begin(), bytes.end(), [&] { return static_cast<char>(random()); });
    return bytes;
}

//! A greeting of ZMTP 3.1 (rfc.zeromq.org/spec/37) for a mechanism, as a client sends it.
std::string greeting(std::string mechanism)
{
    std::string text("\xff\0\0\0\0\0\0\0\1\x7f\3\1", 12);
    mechanism.resize(20);
    return text + mechanism + std::string(32, '\0');
}

void throw_at(int port, std::string const& bytes)
{
    int const s = tcp::connect("127.0.0.1", port);
    if (s < 0) return;
    (void)!::send(s, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    ::close(s);
}

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
        int const port = free_ports();
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
    int const port = free_ports();
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
    int const port = free_ports();
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
        int const port = free_ports();
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
        int const port = free_ports();
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
        int const port = free_ports();
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
    int const port = free_ports();
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

TEST_CASE("Z16: who does not belong is refused, and both sides are told why")
{
    Keys const good, other;
    auto const both = [](std::filesystem::path const& seen_by_a, std::filesystem::path const& seen_by_b,
                         std::string const& told_a, std::string const& told_b) {
        int const port = free_ports();
        auto const a = member(0, with_hosts(port, seen_by_a)), b = member(1, with_hosts(port, seen_by_b));
        CHECK(within(patience, [&] {
            CHECK(!a->try_send(1, suite::numbered(0, 1, 10)));
            CHECK(!b->try_send(0, suite::numbered(1, 1, 10)));
            CHECK(!a->receive(milliseconds(5)));
            CHECK(!b->receive(milliseconds(5)));
            return a->trouble(1) == told_a && b->trouble(0).find(told_b) != std::string::npos;
        }));
        CHECK(a->trouble(1) == told_a);
        INFO(b->trouble(0));
        CHECK(b->trouble(0).find(told_b) != std::string::npos);
    };
    auto mixed = [&](char const* from_other) {  // good's keys, but this one from elsewhere
        auto scratch = std::make_unique<in_threads::Scratch>();
        for (char const* file : {"a.public", "a.secret", "b.public", "b.secret"})
            std::filesystem::copy(good.scratch.path() / file, scratch->path() / file);
        for (char const* kind : {".public", ".secret"}) {
            auto const file = std::string(from_other) + kind;
            std::filesystem::copy(other.scratch.path() / file, scratch->path() / file,
                                  std::filesystem::copy_options::overwrite_existing);
        }
        return scratch;
    };
    SUBCASE("b's key is not in a's list")
    {
        auto const keys = mixed("b");
        both(good.scratch.path(), keys->path(),
             "a connection in its place was refused: it showed the unknown key " + other.open("b"),
             "this one's key is not in its allow-list");
    }
    SUBCASE("b has another key of a's")
    {
        auto const keys = mixed("a");
        both(good.scratch.path(), keys->path(), "the other side has a wrong public key for this one",
             "its key is not the one known here");
    }
    SUBCASE("one side uses keys, the other none")
    {
        both(good.scratch.path(), "", "the other side uses no CURVE keys",
             "the other side uses CURVE keys, this one none");
        both("", good.scratch.path(), "the other side uses CURVE keys, this one none",
             "the other side uses no CURVE keys");
    }
}

TEST_CASE("Z16: the secret of one participant does not open the place of another")
{
    Keys const keys;
    sluice::make_key_pair(keys.scratch.path(), "c");
    int const port = free_ports();
    Network network = with_hosts(port, keys.scratch.path());
    network.hosts.push_back("127.0.0.1");
    auto const a = sluice::make_zmq_transport({{"a", "b", "c"}, 0}, network);
    Stranger const c(port + 1, curve(keys.open("a"), keys.pair("c")));  // comes to the port that is b's
    c.send("I am b");
    CHECK(within(patience, [&] { return !a->trouble(1).empty(); }));
    CHECK(a->trouble(1) == "a connection in its place was refused: it showed the key of \"c\"");
    CHECK(quiet(*a));
}

TEST_CASE("another run on the same port, and another version, are told apart")
{
    in_threads::Scratch one, two;
    int const port = free_ports();
    auto const a = member(0, over_loopback(one, port));
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
}

TEST_CASE("Z17: no keys are used, nor looked for, on ipc and loopback")
{
    in_threads::Scratch scratch;
    for (auto network : {over_ipc(scratch), over_loopback(scratch, free_ports())}) {
        network.keys = scratch.path() / "nowhere";
        auto const a = member(0, network), b = member(1, network);
        CHECK(meet(*a, *b));
        CHECK(talk(*a, *b, 3));
    }
}

TEST_CASE("CURVE: messages arrive whole and in order")
{
    Keys const keys;
    auto const network = with_hosts(free_ports(), keys.scratch.path());
    auto const a = member(0, network), b = member(1, network);
    auto both_parts = [](Transport& t, int self) {
        suite::in_order(t, self);
        suite::round_trips(t, self);
    };
    std::string wrong;
    std::thread other([&] {
        try {
            both_parts(*b, 1);
        } catch (std::exception const& e) {
            wrong = e.what();
        }
    });
    CHECK_NOTHROW(both_parts(*a, 0));
    other.join();
    INFO("a: " << a->lost(1) << " " << a->trouble(1) << "; b: " << b->lost(0) << " " << b->trouble(0));
    CHECK(wrong == "");
}

TEST_CASE("keys: files that others can read or change, that are torn or do not belong together are refused")
{
    auto const refused = [](std::filesystem::path const& keys, std::string const& part) {
        try {
            (void)member(0, with_hosts(free_ports(), keys));
            FAIL("not refused: " << part);
        } catch (sluice::Error const& e) {
            CHECK(e.exit() == sluice::Exit::security);
            INFO(std::string(e.what()));
            CHECK(std::string(e.what()).find(part) != std::string::npos);
        }
    };
    Keys const keys;
    auto const dir = keys.scratch.path();
    auto const [open, secret] = sluice::read_key_pair(dir, "a");
    for (mode_t const mode : {0640, 0604, 0660}) {
        ::chmod((dir / "a.secret").c_str(), mode);
        refused(dir, "others than its owner can read it");
    }
    ::chmod((dir / "a.secret").c_str(), 0600);
    ::chmod((dir / "b.public").c_str(), 0666);
    refused(dir, "others than its owner can change it");
    ::chmod((dir / "b.public").c_str(), 0644);
    std::filesystem::copy(dir / "b.public", dir / "a.public", std::filesystem::copy_options::overwrite_existing);
    refused(dir, "does not belong to a.secret");
    std::ofstream(dir / "a.public") << open << "\n";
    std::ofstream(dir / "b.public") << "short\n";
    refused(dir, "b.public: not a key");
    std::filesystem::remove(dir / "b.public");
    refused(dir, "sluice keygen");
    CHECK_THROWS_AS(sluice::make_key_pair(dir, "a"), sluice::Error);
    sluice::make_key_pair(dir, "new");
    CHECK(sluice::read_key_pair(dir, "new").secret != secret);
}
