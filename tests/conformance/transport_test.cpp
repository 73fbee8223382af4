#include <doctest/doctest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <functional>
#include <memory>
#include <thread>

#include "coupler/base/error.hpp"
#include "tests/conformance/transport_suite.hpp"
#include "tests/support/ports.hpp"
#include "tests/support/scratch.hpp"

namespace {

using sluice::Members;
using sluice::Transport;
using std::chrono::milliseconds;

//! Makes the transport of a member; the calls come from different threads.
using Make = std::function<std::unique_ptr<Transport>(int self)>;
using Side = std::function<void(Transport&, int self)>;

//! Runs all sides in threads; returns what went wrong, empty if nothing did.
std::string converse(Make const& make, Side const& side, int count = 2)
{
    std::vector<std::string> wrong(static_cast<std::size_t>(count));
    std::vector<std::thread> threads;
    for (int self = 0; self < count; ++self)
        threads.emplace_back([&, self] {
            try {
                auto transport = make(self);
                side(*transport, self);
            } catch (std::exception const& e) {
                wrong[static_cast<std::size_t>(self)] = e.what();
            }
        });
    for (auto& thread : threads) thread.join();
    std::string all;
    for (auto const& w : wrong) all += w;
    return all;
}

Members members(int self, int count = 2)
{
    Members all{{"a", "b", "c"}, self};
    all.names.resize(static_cast<std::size_t>(count));
    return all;
}

std::string tcp_address()
{
    return "tcp://127.0.0.1:" + std::to_string(ports::take());
}

Make ipc(std::filesystem::path const& directory, int count = 2)
{
    return [=](int self) { return sluice::make_zmq_transport(members(self, count), {.directory = directory}); };
}

Make shm(std::filesystem::path const& directory, int count = 2)
{
    return [=](int self) { return sluice::make_shm_transport(members(self, count), {.directory = directory}); };
}

Make tcp(std::string const& address, int count = 2)
{
    return [=](int self) { return sluice::make_zmq_transport(members(self, count), {.address = address}); };
}

//! Member 1 greets and leaves; member 0 must notice within 2 s.
void leave(Transport& t, int self)
{
    std::vector<Transport::Incoming> taken;
    if (self == 1) {
        suite::send(t, 0, suite::numbered(1, 1, 10), taken);
        suite::receive(t);
        return;
    }
    suite::receive(t);
    suite::send(t, 1, suite::numbered(0, 1, 10), taken);
    auto const begin = std::chrono::steady_clock::now();
    while (!t.lost(1)) {
        suite::expect(std::chrono::steady_clock::now() - begin < std::chrono::seconds(2), "loss not noticed in 2 s");
        (void)t.receive(milliseconds(10));
    }
}

//! Member 1 is a process that is killed in the middle of sending; member 0 must notice within 10 s (a busy machine).
//! Returns what went wrong.
std::string kill_one(Make const& make)
{
    pid_t const child = ::fork();
    if (child == 0) {  // no test from here on: this process ends by a signal
        auto const transport = make(1);
        for (int n = 0;; ++n)
            if (!transport->try_send(0, suite::numbered(1, n, 5000))) (void)transport->receive(milliseconds(1));
    }
    std::string wrong;
    try {
        auto const transport = make(0);
        for (int n = 0; n < 100; ++n)
            if (suite::receive(*transport).peer != 1) throw std::runtime_error("wrong sender");
        if (transport->lost(1)) throw std::runtime_error("a peer that is there counts as lost");
        ::kill(child, SIGKILL);
        auto const deadline = std::chrono::steady_clock::now() + std::chrono::seconds(10);
        while (!transport->lost(1)) {
            (void)transport->receive(milliseconds(10));
            suite::expect(std::chrono::steady_clock::now() < deadline, "a death was not noticed in 10 s");
        }
    } catch (std::exception const& e) {
        wrong = e.what();
    }
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    return wrong;
}

}  // namespace

TEST_CASE("loopback: conforms")
{
    sluice::LoopbackHub hub(2);
    CHECK(converse([&](int self) { return hub.connect(self); }, suite::all) == "");
}

TEST_CASE("zmq over ipc: conforms")
{
    in_threads::Scratch scratch;
    CHECK(converse(ipc(scratch.path()), suite::all) == "");
}

TEST_CASE("zmq over tcp: conforms")
{
    CHECK(converse(tcp(tcp_address()), suite::all) == "");
}

TEST_CASE("shm: conforms, by shared memory alone")
{
    in_threads::Scratch scratch;
    std::string kinds[2];
    auto const side = [&](Transport& t, int self) {
        suite::all(t, self);
        kinds[self] = t.kind();
    };
    CHECK(converse(shm(scratch.path()), side) == "");
    CHECK(kinds[0] == "shm");
    CHECK(kinds[1] == "shm");
}

TEST_CASE("every transport but MPI: three members that begin at once, all to all")
{
    in_threads::Scratch a, b;
    sluice::LoopbackHub hub(3);
    Side const side = [](Transport& t, int self) { suite::all_to_all(t, self, 3); };
    CHECK(converse([&](int self) { return hub.connect(self); }, side, 3) == "");
    CHECK(converse(ipc(a.path(), 3), side, 3) == "");
    CHECK(converse(tcp(tcp_address(), 3), side, 3) == "");
    CHECK(converse(shm(b.path(), 3), side, 3) == "");
}

TEST_CASE("every transport but MPI: a peer that leaves is noticed within 2 s")
{
    in_threads::Scratch scratch;
    sluice::LoopbackHub hub(2);
    CHECK(converse(ipc(scratch.path()), leave) == "");
    CHECK(converse(tcp(tcp_address()), leave) == "");
    CHECK(converse(shm(scratch.path()), leave) == "");
    CHECK(converse([&](int self) { return hub.connect(self); }, leave) == "");
}

TEST_CASE("zmq and shm: a peer that is killed while it sends counts as lost")
{
    in_threads::Scratch a, b;
    CHECK(kill_one(ipc(a.path())) == "");
    CHECK(kill_one(tcp(tcp_address())) == "");
    CHECK(kill_one(shm(b.path())) == "");
}

TEST_CASE("zmq: the side that connects may come first, by a second")
{
    in_threads::Scratch scratch;
    for (int late : {0, 1}) {
        auto const make = [&](int self) {
            if (self == late) std::this_thread::sleep_for(milliseconds(1000));
            return sluice::make_zmq_transport(members(self),
                                              {.directory = scratch.path(), .silence = milliseconds(2000)});
        };
        CHECK(converse(make, suite::round_trips) == "");
    }
}

TEST_CASE("zmq over tcp: an address without a port is refused")
{
    for (auto const address : {"tcp://127.0.0.1", "tcp://127.0.0.1:", "tcp://127.0.0.1:99999", "tcp://127.0.0.1:x"})
        CHECK_THROWS_AS(sluice::make_zmq_transport(members(0), {.address = address}), sluice::Error);
}
