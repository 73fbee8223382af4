#include <doctest/doctest.h>

#include "tests/faults/zmq_pair.hpp"

//! How a member ends: what it said is still read, and it does not wait for ever (Z13).
using namespace zmq_pair;

TEST_CASE("Z13: an end waits 0.5 s at most for what nobody takes")
{
    in_threads::Scratch scratch;
    auto const network = over_ipc(scratch);
    Child b([&] { echo(network); });
    auto a = member(0, network);
    REQUIRE(meet_child(*a));
    b.signal(SIGSTOP);
    auto const message = suite::numbered(0, 1, 1'000'000);
    int queued = 0;
    while (a->try_send(1, message)) ++queued;
    CHECK(queued >= 1);
    auto const begin = std::chrono::steady_clock::now();
    a.reset();
    CHECK(std::chrono::steady_clock::now() - begin < seconds(10));  // without a bound: for ever
}

TEST_CASE("Z13: what a peer said before it left is still read")
{
    for (bool const ipc : {true, false})
        for (int const leaver : {0, 1}) {
            in_threads::Scratch scratch;
            auto const network = ipc ? over_ipc(scratch) : over_loopback(scratch, ports::take());
            Owner pair[2] = {member(0, network), member(1, network)};
            REQUIRE(meet(*pair[0], *pair[1]));
            for (int n = 0; n < 8; ++n) REQUIRE(say(*pair[leaver], 1 - leaver, "word " + std::to_string(n)));
            pair[leaver].reset();
            std::this_thread::sleep_for(milliseconds(300));
            for (int n = 0; n < 8; ++n) CHECK(text_from(*pair[1 - leaver]) == "word " + std::to_string(n));
            CHECK(finds_lost(*pair[1 - leaver], leaver));
        }
}

TEST_CASE("Z13: the last words of a listener reach a peer that looks only now and then")
{
    for (bool const ipc : {true, false})
        for (int round = 0; round < 5; ++round) {
            in_threads::Scratch scratch;
            auto const network = ipc ? over_ipc(scratch) : over_loopback(scratch, ports::take());
            auto a = member(0, network);
            auto const b = member(1, network);
            bool const met = round % 2 == 0;
            REQUIRE((met ? meet(*a, *b) : greet(*a, *b)));
            (void)b->receive(milliseconds(0));  // nothing: from here on it is told of messages and of ends together
            std::thread leaver([&] {
                (void)say(*a, 1, "why I stop");
                a.reset();
            });
            std::string heard;
            for (int look = 0; look < 100 && heard.empty(); ++look) {
                std::this_thread::sleep_for(milliseconds(50));
                if (auto const incoming = b->receive(milliseconds(0)))
                    heard.assign(reinterpret_cast<char const*>(incoming->message.bytes.data()),
                                 incoming->message.bytes.size());
            }
            leaver.join();
            CHECK(heard == "why I stop");
        }
}
