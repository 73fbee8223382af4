#include "coupler/wire/message.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "coupler/base/error.hpp"
#include "coupler/transport/buffer.hpp"
#include "coupler/transport/transport.hpp"

using namespace sluice;

namespace {

DataSpec const spec{"load", {{"force", Shape::vector, "N"}, {"torque", Shape::spin, "N m"}}};

//! A frame with numbers of its own.
struct Sample
{
    std::int64_t index = 0;
    std::vector<std::int64_t> ids;
    std::vector<double> force, torque;
};

Sample sample_frame(std::int64_t index, int points)
{
    Sample f{.index = index, .ids = {}, .force = {}, .torque = {}};
    for (int i = 0; i < points; ++i) {
        f.ids.push_back(7 * i);
        f.force.insert(f.force.end(), {0.1 * i, -0.2 * i + static_cast<double>(index)});
        f.torque.push_back(3.0);
    }
    return f;
}

//! The bytes of a frame, in memory of their own.
Message encoded(FrameEncoder& encoder, Sample const& frame)
{
    auto const buffer = std::make_shared<Buffer>();
    auto const room = buffer->room(encoder.bound(frame.ids.size()));
    std::array<std::span<double const>, 2> const columns{frame.force, frame.torque};
    auto const size = encoder.encode({frame.index, 5 * frame.index, 2, frame.ids, columns}, 42, "water", room);
    return {room.first(size), buffer};
}

Frame decoded(FrameDecoder& decoder, Message const& m)
{
    return decoder.decode(open_message(m.bytes, "a"), m.bytes, m.owner, "a");
}

template <class T>
std::vector<T> numbers(std::span<T const> values)
{
    return {values.begin(), values.end()};
}

void check_equal(Frame const& a, Sample const& b)
{
    CHECK(a.index == b.index);
    CHECK(a.ticks == 5 * b.index);
    CHECK(a.iteration == 2);
    CHECK(numbers(a.ids.values) == b.ids);
    CHECK(numbers(a.columns[0].values) == b.force);
    CHECK(numbers(a.columns[1].values) == b.torque);
}

constexpr std::size_t padded(std::size_t bytes)
{
    return (bytes + 63) / 64 * 64;
}

}  // namespace

TEST_CASE("frame: comes back as it went, with points that change in number and order")
{
    FrameEncoder encoder(spec, 2, 0);
    FrameDecoder decoder(spec, 2);
    for (int points : {3, 3, 5, 0, 0, 4, 5000, 5000, 1}) {  // 5000: more than the block that is hashed at once
        auto const frame = sample_frame(points, points);
        check_equal(decoded(decoder, encoded(encoder, frame)), frame);
    }
}

TEST_CASE("frame: stays whole while its message is held, and without it for columns that did not travel")
{
    FrameEncoder encoder(spec, 2, 0);
    FrameDecoder decoder(spec, 2);
    std::vector<Frame> frames;
    std::weak_ptr<void const> first;
    for (int n = 0; n < 4; ++n) {
        auto const message = encoded(encoder, sample_frame(n, 100));
        if (n == 0) first = message.owner;
        frames.push_back(decoded(decoder, message));
    }
    for (int n = 0; n < 4; ++n) check_equal(frames[static_cast<std::size_t>(n)], sample_frame(n, 100));
    frames.erase(frames.begin());
    CHECK(first.expired());  // ids and torque travelled in it alone, and were copied
    check_equal(frames[0], sample_frame(1, 100));
}

TEST_CASE("frame: numbers that do not stand aligned are read all the same")
{
    FrameEncoder encoder(spec, 2, 0);
    FrameDecoder decoder(spec, 2);
    auto const good = encoded(encoder, sample_frame(3, 10));
    auto const shifted = std::make_shared<std::vector<std::byte>>(good.bytes.size() + 1);
    std::copy(good.bytes.begin(), good.bytes.end(), shifted->begin() + 1);
    check_equal(decoded(decoder, {std::span<std::byte const>(*shifted).subspan(1), shifted}), sample_frame(3, 10));
}

TEST_CASE("frame: a column that did not change is not sent again")
{
    FrameEncoder encoder(spec, 2, 0);
    auto const first = encoded(encoder, sample_frame(0, 100)).bytes.size();
    auto const second = encoded(encoder, sample_frame(1, 100)).bytes.size();
    auto const third = encoded(encoder, sample_frame(1, 100)).bytes.size();
    std::size_t const head = padded(sizeof(Header) + 3 * sizeof(Digest));
    CHECK(first == head + padded(800) + padded(1600) + padded(800));
    CHECK(second == head + 1600);  // force changed; ids and torque did not
    CHECK(third == sizeof(Header));
    encoder.forget();
    CHECK(encoded(encoder, sample_frame(1, 100)).bytes.size() == first);
}

TEST_CASE("frame: a column that the receiver does not read is not sent")
{
    FrameEncoder encoder(spec, 2, 0, 2u);
    FrameDecoder decoder(spec, 2, 2u);
    auto const message = encoded(encoder, sample_frame(0, 100));
    CHECK(message.bytes.size() == padded(sizeof(Header) + 3 * sizeof(Digest)) + padded(800) + padded(800));
    auto const frame = decoded(decoder, message);
    CHECK(frame.columns[0].values.empty());
    CHECK(numbers(frame.columns[1].values) == sample_frame(0, 100).torque);
}

TEST_CASE("frame: a number that is not finite stops the sender with column, id and frame")
{
    FrameEncoder encoder(spec, 2, 0);
    for (auto const& [points, at] : {std::pair{3, 4}, std::pair{5000, 9999}}) {
        auto frame = sample_frame(5, points);
        frame.force[static_cast<std::size_t>(at)] = points == 3 ? std::nan("") : HUGE_VAL;
        try {
            encoded(encoder, frame);
            FAIL("not refused");
        } catch (Error const& e) {
            CHECK(e.exit() == Exit::numerical);
            auto const id = std::to_string(7 * (at / 2));
            CHECK(std::string(e.what()).find("\"water\": load.force of id " + id + " is not finite in frame 5") !=
                  std::string::npos);
        }
    }
}

namespace {

//! A message with a change: refused when it is opened or when it is decoded.
bool is_refused(std::span<std::byte const> bytes)
{
    FrameDecoder decoder(spec, 2);
    try {
        decoder.decode(open_message(bytes, "a"), bytes, nullptr, "a");
    } catch (Error const& e) {
        return e.exit() == Exit::protocol;
    }
    return false;
}

}  // namespace

TEST_CASE("message: every single bit flip is refused")
{
    FrameEncoder encoder(spec, 2, 0);
    auto const message = encoded(encoder, sample_frame(0, 2));
    auto const good = message.bytes;
    CHECK_FALSE(is_refused(good));
    for (std::size_t bit = 0; bit < good.size() * 8; ++bit) {
        Bytes bad(good.begin(), good.end());
        bad[bit / 8] ^= std::byte(1u << (bit % 8));
        CHECK(is_refused(bad));
    }
}

TEST_CASE("message: truncation at every length and noise are refused")
{
    FrameEncoder encoder(spec, 2, 0);
    auto const message = encoded(encoder, sample_frame(0, 2));
    auto const good = message.bytes;
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
    auto const message = encoded(encoder, sample_frame(0, 2));
    Header const right = open_message(message.bytes, "a");
    auto refused = [&](auto change) {
        Header header = right;
        change(header);
        FrameDecoder decoder(spec, 2);
        CHECK_THROWS_AS(decoder.decode(header, message.bytes, message.owner, "a"), Error);
    };
    refused([](Header& h) { h.points = std::numeric_limits<std::uint32_t>::max(); });
    refused([](Header& h) { h.points = 9; });
    refused([](Header& h) { h.columns = ids_bit | 1u; });
    refused([](Header& h) { h.columns = 3u; });
    refused([](Header& h) { h.columns |= 8u; });
}

TEST_CASE("message: a text and numbers survive, and empty ones too")
{
    Header header;
    header.kind = MessageKind::abort;
    header.frame = 17;
    for (std::string const text : {"why it stopped", ""}) {
        auto const bytes = encode_text(header, text);
        CHECK(open_message(bytes, "a").kind == MessageKind::abort);
        CHECK(open_message(bytes, "a").frame == 17);
        CHECK(text_of(bytes) == text);
    }
    for (auto const& values : {std::vector<double>{1.5, -0.0, 3e300}, std::vector<double>{}}) {
        auto const bytes = encode(header, std::as_bytes(std::span(values)));
        open_message(bytes, "a");
        CHECK(numbers_of(bytes) == values);
    }
    seal(header);
    CHECK(open_message(bytes_of(header), "a").frame == 17);
}
