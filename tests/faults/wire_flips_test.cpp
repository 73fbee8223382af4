#include <doctest/doctest.h>

#include <array>
#include <cmath>

#include "coupler/wire/message.hpp"
#include "tests/faults/zmq_pair.hpp"
#include "tests/support/fault_row.hpp"
#include "tests/support/tcp_proxy.hpp"

//! Row F12 of the fault matrix: bits that flip behind TCP's checksum, in frames over a real connection.
using namespace zmq_pair;

namespace {

sluice::DataSpec const load{"load", {{"force", sluice::Shape::vector, "N"}, {"torque", sluice::Shape::spin, "N m"}}};

//! Frame `index` of 20 points, as a message.
sluice::Bytes frame(int index)
{
    std::vector<std::int64_t> ids;
    std::vector<double> force, torque;
    for (int i = 0; i < 20; ++i) {
        ids.push_back(3 * i);
        force.insert(force.end(), {0.1 * i, std::sqrt(index + 1.0)});
        torque.push_back(-0.5 * i * index);
    }
    std::array<std::span<double const>, 2> const columns{force, torque};
    sluice::FrameEncoder encoder(load, 2, 0);
    alignas(64) static std::byte room[4096];
    auto const size = encoder.encode({index, 7 * index, 0, ids, columns}, 42, "a", std::span(room));
    return {room, room + size};
}

//! What was flipped is refused at the latest when its frame is decoded.
bool refused(sluice::Message const& message)
{
    try {
        auto const header = sluice::open_message(message.bytes, "a");
        sluice::FrameDecoder(load, 2).decode(header, message.bytes, message.owner, "a");
    } catch (sluice::Error const& e) {
        CHECK(e.exit() == sluice::Exit::protocol);
        return true;
    }
    return false;
}

}  // namespace

TEST_CASE("F12: bits of frames flipped behind TCP's checksum are all refused, what is not damaged is taken")
{
    Apart apart;
    auto& [port, proxy, a, b] = apart;
    REQUIRE(meet(*a, *b));
    sluice::test::Row row("F12", "flipped bits, each refused, and the frame after it taken",
                          {.brief = 500, .stated = 10'000});
    while (row.next()) {
        auto const sent = frame(row.round());
        proxy.flip = sent.size();
        REQUIRE(within(patience, [&] { return a->try_send(1, sent); }));
        auto const damaged = suite::receive(*b);
        REQUIRE(damaged.message.bytes.size() == sent.size());
        CHECK(proxy.flips == row.round() + 1);
        CHECK(!std::equal(sent.begin(), sent.end(), damaged.message.bytes.begin()));
        CHECK(refused(damaged.message));
        if (row.round() % 50 != 0) continue;
        REQUIRE(within(patience, [&] { return a->try_send(1, sent); }));
        CHECK(!refused(suite::receive(*b).message));
    }
}
