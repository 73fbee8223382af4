#include <doctest/doctest.h>
#include <sys/stat.h>

#include <fstream>

#include "tests/faults/strangers.hpp"
#include "tests/faults/zmq_pair.hpp"

//! CURVE: who is let in, who is refused and told why, and which files of keys are taken (Z16, Z17).
using namespace zmq_pair;
using namespace strangers;

namespace {

bool quiet(Transport& t)
{
    return !t.receive(milliseconds(100));
}

}  // namespace

TEST_CASE("Z16: who does not belong is refused, and both sides are told why")
{
    Keys const good, other;
    auto const both = [](std::filesystem::path const& seen_by_a, std::filesystem::path const& seen_by_b,
                         std::string const& told_a, std::string const& told_b) {
        int const port = ports::take();
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
    int const port = ports::take();
    Network network = with_hosts(port, keys.scratch.path());
    network.hosts.push_back("127.0.0.1");
    auto const a = sluice::make_zmq_transport({{"a", "b", "c"}, 0}, network);
    Stranger const c(port + 1, curve(keys.open("a"), keys.pair("c")));  // comes to the port that is b's
    c.send("I am b");
    CHECK(within(patience, [&] { return !a->trouble(1).empty(); }));
    CHECK(a->trouble(1) == "a connection in its place was refused: it showed the key of \"c\"");
    CHECK(quiet(*a));
}

TEST_CASE("Z17: no keys are used, nor looked for, on ipc and loopback")
{
    in_threads::Scratch scratch;
    for (auto network : {over_ipc(scratch), over_loopback(scratch, ports::take())}) {
        network.keys = scratch.path() / "nowhere";
        auto const a = member(0, network), b = member(1, network);
        CHECK(meet(*a, *b));
        CHECK(talk(*a, *b, 3));
    }
}

TEST_CASE("CURVE: messages arrive whole and in order")
{
    Keys const keys;
    auto const network = with_hosts(ports::take(), keys.scratch.path());
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
            (void)member(0, with_hosts(ports::take(), keys));
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
