#include "coupler/wire/message.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "coupler/base/error.hpp"

using namespace sluice;

namespace {

DataSpec const spec{"load", {{"force", Shape::vector, "N"}, {"torque", Shape::spin, "N m"}}};

Frame sample_frame(std::int64_t index, int points)
{
    Frame f{.index = index, .time = 0.5 * static_cast<double>(index), .ids = {}, .columns = {{}, {}}};
    for (int i = 0; i < points; ++i) {
        f.ids.push_back(7 * i);
        f.columns[0].insert(f.columns[0].end(), {0.1 * i, -0.2 * i + static_cast<double>(index)});
        f.columns[1].push_back(3.0);
    }
    return f;
}

std::span<std::byte const> bytes_of(FrameEncoder& encoder, Frame frame)
{
    return encoder.encode(frame, 42, "a");
}

Frame through(FrameEncoder& encoder, FrameDecoder& decoder, Frame frame)
{
    auto const bytes = encoder.encode(frame, 42, "a");
    return decoder.decode(open_message(bytes, "a"), bytes, "a");
}

void check_equal(Frame const& a, Frame const& b)
{
    CHECK(a.index == b.index);
    CHECK(a.time == b.time);
    CHECK(a.ids == b.ids);
    CHECK(a.columns == b.columns);
}

}  // namespace

TEST_CASE("frame: comes back as it went, with points that change in number and order")
{
    FrameEncoder encoder(spec, 2, 0);
    FrameDecoder decoder(spec, 2);
    for (int points : {3, 3, 5, 0, 4}) {
        auto const frame = sample_frame(points, points);
        check_equal(through(encoder, decoder, frame), frame);
    }
}

TEST_CASE("frame: a column that did not change is not sent again")
{
    FrameEncoder encoder(spec, 2, 0);
    auto const first = bytes_of(encoder, sample_frame(0, 100)).size();
    auto const second = bytes_of(encoder, sample_frame(1, 100)).size();
    CHECK(first == sizeof(Header) + 100 * (8 + 16 + 8));
    CHECK(second == sizeof(Header) + 100 * 16);  // force changed; ids and torque did not
}

TEST_CASE("frame: a number that is not finite stops the sender with column, id and frame")
{
    FrameEncoder encoder(spec, 2, 0);
    auto frame = sample_frame(5, 3);
    frame.columns[0][4] = std::nan("");
    try {
        encoder.encode(frame, 42, "water");
        FAIL("not refused");
    } catch (Error const& e) {
        CHECK(e.exit() == Exit::numerical);
        CHECK(std::string(e.what()).find("\"water\": load.force of id 14 is not finite in frame 5") !=
              std::string::npos);
    }
}

TEST_CASE("message: every single bit flip is refused")
{
    FrameEncoder encoder(spec, 2, 0);
    auto const good = bytes_of(encoder, sample_frame(0, 2));
    for (std::size_t bit = 0; bit < good.size() * 8; ++bit) {
        Bytes bad(good.begin(), good.end());
        bad[bit / 8] ^= std::byte(1u << (bit % 8));
        CHECK_THROWS_AS(open_message(bad, "a"), Error);
    }
}

TEST_CASE("message: truncation at every length and noise are refused")
{
    FrameEncoder encoder(spec, 2, 0);
    auto const good = bytes_of(encoder, sample_frame(0, 2));
    for (std::size_t length = 0; length < good.size(); ++length)
        CHECK_THROWS_AS(open_message(good.first(length), "a"), Error);
    std::mt19937 random(1);
    for (int trial = 0; trial < 1000; ++trial) {
        Bytes noise(random() % 300);
        for (auto& b : noise) b = std::byte(random());
        CHECK_THROWS_AS(open_message(noise, "a"), Error);
    }
}

TEST_CASE("frame: columns, points and lengths that do not fit are refused before anything is allocated")
{
    FrameEncoder encoder(spec, 2, 0);
    auto const good = bytes_of(encoder, sample_frame(0, 2));
    Header const right = open_message(good, "a");
    Bytes const message(good.begin(), good.end());
    auto refused = [&](auto change) {
        Header header = right;
        change(header);
        FrameDecoder decoder(spec, 2);
        CHECK_THROWS_AS(decoder.decode(header, message, "a"), Error);
    };
    refused([](Header& h) { h.points = std::numeric_limits<std::uint64_t>::max() / 8; });
    refused([](Header& h) { h.points = 3; });
    refused([](Header& h) { h.columns = ids_bit | 1u; });
    refused([](Header& h) { h.columns = 3u; });
    refused([](Header& h) { h.columns |= 8u; });
}

TEST_CASE("message: a text survives, and an empty one too")
{
    for (std::string const text : {"why it stopped", ""}) {
        auto const bytes = encode_text(MessageKind::abort, 1, 17, text);
        auto const header = open_message(bytes, "a");
        CHECK(header.kind == MessageKind::abort);
        CHECK(header.frame == 17);
        CHECK(text_of(bytes) == text);
    }
}
