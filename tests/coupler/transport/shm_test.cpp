#include "coupler/transport/shm.hpp"

#include <doctest/doctest.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cstring>
#include <fstream>
#include <functional>
#include <thread>

#include "coupler/base/error.hpp"
#include "coupler/transport/shm_note.hpp"
#include "tests/conformance/transport_suite.hpp"
#include "tests/support/scratch.hpp"

namespace {

using in_threads::Scratch;
using sluice::Note;
using sluice::Trailer;
using sluice::Transport;
using std::chrono::milliseconds;
using std::chrono::seconds;
using Clock = std::chrono::steady_clock;
using Made = std::unique_ptr<Transport>;

Made shm(std::filesystem::path const& directory, int self, int count = 2)
{
    sluice::Members members{{"a", "b", "c"}, self};
    members.names.resize(static_cast<std::size_t>(count));
    return sluice::make_shm_transport(members, {.directory = directory, .silence = milliseconds(5000)});
}

//! Runs the functions in threads; returns what they threw.
std::string together(std::vector<std::function<void()>> const& sides)
{
    std::vector<std::string> wrong(sides.size());
    std::vector<std::thread> threads;
    for (std::size_t i = 0; i < sides.size(); ++i)
        threads.emplace_back([&, i] {
            try {
                sides[i]();
            } catch (std::exception const& e) {
                wrong[i] = e.what();
            }
        });
    for (auto& thread : threads) thread.join();
    std::string all;
    for (auto const& w : wrong) all += w;
    return all;
}

//! Takes part in the handshake until messages go by `kind`; returns what came meanwhile.
std::vector<Transport::Incoming> until_kind(Transport& t, std::string const& kind)
{
    std::vector<Transport::Incoming> taken;
    auto const deadline = Clock::now() + seconds(20);
    while (t.kind() != kind) {
        suite::expect(Clock::now() < deadline, "after 20 s messages go by " + t.kind());
        if (auto incoming = t.receive(milliseconds(1))) taken.push_back(std::move(*incoming));
    }
    return taken;
}

//! Receives, and forgets, until `stage` is reached.
void attend(Transport& t, std::atomic<int> const& stage, int reached)
{
    auto const deadline = Clock::now() + seconds(40);
    while (stage < reached) {
        suite::expect(Clock::now() < deadline, "stage " + std::to_string(reached) + " not reached within 40 s");
        (void)t.receive(milliseconds(5));
    }
}

//! How many views of shared memory this process has.
int views()
{
    std::ifstream maps("/proc/self/maps");
    int count = 0;
    for (std::string line; std::getline(maps, line);) count += line.find("memfd:sluice") != std::string::npos;
    return count;
}

//! A network over which the offers of one member lead nowhere, as if it were on another host.
class FarFrom final : public Transport
{
 public:
    FarFrom(Made inner, int far) : inner_(std::move(inner)), far_(far) {}
    std::span<std::byte> reserve(int peer, std::size_t size) override { return inner_->reserve(peer, size); }
    bool commit(int peer, std::size_t size) override { return inner_->commit(peer, size); }
    bool lost(int peer) const override { return inner_->lost(peer); }
    std::string kind() const override { return "network"; }

    std::optional<Incoming> receive(std::chrono::microseconds patience) override
    {
        auto incoming = inner_->receive(patience);
        if (!incoming || incoming->peer != far_) return incoming;
        auto const bytes = incoming->message.bytes;
        auto const trailer = sluice::trailer_of(bytes);
        if (!trailer || trailer->content != Trailer::Content::note) return incoming;
        auto note = sluice::note_in(bytes.first(bytes.size() - sizeof(Trailer))).value();
        note.process = 0;
        auto copy = std::make_shared<suite::Bytes>(bytes.begin(), bytes.end());
        sluice::put(copy->data(), note);
        incoming->message = {*copy, copy};
        return incoming;
    }

 private:
    Made inner_;
    int far_;
};

//! Greets `peer` until a greeting of its own has come, and then once more: now it is there.
void meet(Transport& t, int self, int peer, std::string const& what)
{
    auto const deadline = Clock::now() + seconds(20);
    auto const greeting = suite::numbered(self, 1, 100);
    for (bool arrived = false, greeted = false; !(arrived && greeted);) {
        suite::expect(Clock::now() < deadline, what + ": no greeting within 20 s");
        (void)t.lost(peer);
        greeted = t.try_send(peer, greeting) && arrived;
        auto const incoming = t.receive(milliseconds(5));
        if (!incoming) continue;
        suite::expect(suite::same(*incoming, suite::numbered(peer, 1, 100)), what + ": not a greeting");
        arrived = true;
    }
}

//! Takes greetings that are left over.
void drain(Transport& t)
{
    while (t.receive(milliseconds(50))) {
    }
}

}  // namespace

TEST_CASE("shm: messages outlive the transport, and then nothing is left of it")
{
    Scratch scratch;
    Transport::Incoming kept;
    auto const bytes = suite::numbered(1, 1, 100'000);
    std::atomic<int> received = 0;
    auto const wrong = together({[&] {
                                     auto t = shm(scratch.path(), 0);
                                     auto taken = until_kind(*t, "shm");
                                     kept = taken.empty() ? suite::receive(*t) : std::move(taken[0]);
                                     received = 1;
                                 },
                                 [&] {
                                     auto t = shm(scratch.path(), 1);
                                     until_kind(*t, "shm");
                                     suite::expect(t->try_send(0, bytes), "no room");
                                     attend(*t, received, 1);
                                 }});
    CHECK(wrong == "");
    CHECK(suite::same(kept, bytes));
    CHECK(views() > 0);
    kept.message = {};
    CHECK(views() == 0);
}

TEST_CASE("shm: the last messages of a process that was killed arrive, and then it counts as lost, and leaves nothing")
{
    Scratch scratch;
    constexpr int last = 20;
    int const views_before = views();
    pid_t const child = ::fork();
    REQUIRE(child >= 0);
    if (child == 0) {  // no test from here on: this process ends by its own hand
        auto t = shm(scratch.path(), 1);
        auto const early = until_kind(*t, "shm");
        if (!t->try_send(0, suite::numbered(1, 0, 10))) ::_exit(1);
        if (early.empty()) (void)suite::receive(*t);
        for (int n = 0; n < last; ++n)
            if (!t->try_send(0, suite::numbered(1, n, 1000))) ::_exit(1);
        ::kill(::getpid(), SIGKILL);
    }
    {
        auto t = shm(scratch.path(), 0);
        // its first message in shared memory has been read: its word that it moved, which can be lost, was not
        if (until_kind(*t, "shm").empty()) (void)suite::receive(*t);
        REQUIRE(t->try_send(1, suite::numbered(0, 0, 10)));
        int status = 0;
        REQUIRE(::waitpid(child, &status, 0) == child);
        CHECK(WIFSIGNALED(status));
        std::vector<Transport::Incoming> all;
        for (int n = 0; n < last; ++n) {
            CHECK_FALSE(t->lost(1));
            all.push_back(suite::receive(*t));
        }
        for (int n = 0; n < last; ++n)
            CHECK(suite::same(all[static_cast<std::size_t>(n)], suite::numbered(1, n, 1000)));
        auto const deadline = Clock::now() + seconds(10);
        while (!t->lost(1) && Clock::now() < deadline) CHECK_FALSE(t->receive(milliseconds(10)));
        CHECK(t->lost(1));
    }
    CHECK(views() == views_before);
}

TEST_CASE("shm: pairs on different hosts stay on the network, the others do not, and all are woken")
{
    Scratch scratch;
    std::atomic<int> done = 0, all_met = 0;
    auto const all_to_all = [&all_met](Transport& t, int self) {
        suite::all_to_all(t, self, 3);
        ++all_met;  // nobody goes on before all have what was for them
        auto const deadline = Clock::now() + seconds(40);
        while (all_met < 3 && Clock::now() < deadline) std::this_thread::sleep_for(milliseconds(1));
    };
    auto member = [&](int self, auto const& body) {
        return [&, self, body] {
            sluice::Members const members{{"a", "b", "c"}, self};
            Made network = sluice::make_zmq_transport(members, {.directory = scratch.path()});
            if (self != 1) network = std::make_unique<FarFrom>(std::move(network), self == 0 ? 2 : 0);
            auto const t = sluice::make_shm_over(members, std::move(network));
            body(*t);
        };
    };
    auto const talk = [&](int self) {
        return [self, &done, &all_to_all](Transport& t) {
            all_to_all(t, self);
            suite::woken(t, self);
            suite::kept(t, self);
            suite::expect(until_kind(t, self == 0 ? "shm 1, network 1" : "shm").empty(), "a message of nobody's");
            ++done;
            attend(t, done, 3);
        };
    };
    auto const third = [&](Transport& t) {
        all_to_all(t, 2);
        suite::expect(until_kind(t, "shm 1, network 1").empty(), "a message of nobody's");
        ++done;
        attend(t, done, 3);
    };
    CHECK(together({member(0, talk(0)), member(1, talk(1)), member(2, third)}) == "");
}

//! Meets a peer that ends and is started again. Stages: 1 both have met, 2 the end is noticed, 3 both have met again.
void survive(std::filesystem::path const& directory, int self, std::atomic<int>& stage)
{
    int const peer = 1 - self;
    auto t = shm(directory, self);
    meet(*t, self, peer, "first life");
    until_kind(*t, "shm");
    stage = 1;
    auto const deadline = Clock::now() + seconds(20);
    while (!t->lost(peer)) {
        suite::expect(Clock::now() < deadline, "not lost within 20 s");
        (void)t->receive(milliseconds(5));
    }
    drain(*t);
    stage = 2;
    meet(*t, self, peer, "second life");
    until_kind(*t, "shm");
    stage = 3;
    attend(*t, stage, 4);
}

void live_twice(std::filesystem::path const& directory, int self, std::atomic<int>& stage)
{
    {
        auto t = shm(directory, self);
        meet(*t, self, 1 - self, "first life");
        attend(*t, stage, 1);
    }
    auto const deadline = Clock::now() + seconds(40);
    while (stage < 2 && Clock::now() < deadline) std::this_thread::sleep_for(milliseconds(1));
    auto t = shm(directory, self);
    meet(*t, self, 1 - self, "second life");
    attend(*t, stage, 3);
    stage = 4;
}

TEST_CASE("shm: a peer that is started again before everybody has met is met again")
{
    for (int self : {0, 1}) {
        Scratch scratch;
        std::atomic<int> stage = 0;
        CAPTURE(self);
        CHECK(together({[&] { survive(scratch.path(), self, stage); },
                        [&] { live_twice(scratch.path(), 1 - self, stage); }}) == "");
    }
}

TEST_CASE("shm: an offer that leads elsewhere is not opened")
{
    auto const token = sluice::random_token();
    sluice::ShmOutbox const out;
    auto const here = out.address();
    CHECK(sluice::ShmInbox::open(here, out.token()) != nullptr);
    CHECK(sluice::ShmInbox::open(here, token) == nullptr);                     // another queue
    CHECK(sluice::ShmInbox::open({here.process, 0}, out.token()) == nullptr);  // not of ours
    CHECK(sluice::ShmInbox::open({here.process, -1}, out.token()) == nullptr);
    CHECK(sluice::ShmInbox::open({-1, 3}, out.token()) == nullptr);
    auto const small = sluice::SharedFile::create(4096);
    CHECK(sluice::ShmInbox::open(small.address(), out.token()) == nullptr);  // reading it would end this process
    int ends[2];
    REQUIRE(::pipe(ends) == 0);
    CHECK(sluice::ShmInbox::open({here.process, ends[0]}, out.token()) == nullptr);
    ::close(ends[0]);
    ::close(ends[1]);
}

TEST_CASE("shm: a broken sender is an error, not a crash")
{
    struct Wrong
    {
        std::uint64_t size;
        std::uint32_t slot;
    };
    constexpr std::uint64_t gib = std::uint64_t{1} << 30;
    for (auto const wrong :
         {Wrong{10, 64}, Wrong{10, ~0U}, Wrong{gib + 1, 0}, Wrong{~std::uint64_t{0}, 5}, Wrong{10, 3}}) {
        sluice::ShmOutbox out;
        auto const in = sluice::ShmInbox::open(out.address(), out.token());
        REQUIRE(in);
        auto file = sluice::SharedFile::open(out.address(), 4096);
        auto const page = file->map(0, 65'536, sluice::SharedFile::Access::write);
        auto* const ring = std::launder(reinterpret_cast<sluice::Ring*>(page.data() + alignof(sluice::Ring)));
        for (std::uint32_t n = 0; n < 2; ++n) {
            ring->entries[n].size = n == 0 ? 10 : wrong.size;
            ring->entries[n].slot = n == 0 ? 3 : wrong.slot;
            ring->entries[n].number = n + 1;
        }
        auto const kept = in->take();
        REQUIRE(kept);
        CHECK_THROWS_AS(in->take(), sluice::Error);
        ring->entries[2].number = 77;  // not the next one
        CHECK_FALSE(in->ready());
    }
}

TEST_CASE("shm: more than 1 GiB is refused, and having no memory is an error, not the end of the process")
{
    sluice::ShmOutbox out;
    CHECK_THROWS_AS(out.reserve(sluice::ShmOutbox::largest_message + 1), sluice::Error);
    CHECK_THROWS_AS(sluice::SharedFile::create(std::size_t{1} << 63), sluice::Error);
    auto const file = sluice::SharedFile::create(65'536);
    CHECK_THROWS_AS(file.allocate(0, std::size_t{1} << 50), sluice::Error);  // more than there is, not tried
    CHECK_THROWS_AS(file.allocate((std::size_t{1} << 63) - 65'536, 65'536), sluice::Error);
}

TEST_CASE("shm: a message without a trailer names the mistake")
{
    sluice::LoopbackHub hub(2);
    auto const mine = sluice::make_shm_over({{"a", "b"}, 0}, hub.connect(0));
    auto const other = hub.connect(1);
    REQUIRE(other->try_send(0, suite::numbered(1, 1, 50)));
    CHECK_THROWS_WITH_AS(mine->receive(seconds(5)), doctest::Contains("same transport"), sluice::Error);
}
