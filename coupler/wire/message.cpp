#include "coupler/wire/message.hpp"

#include <xxhash.h>

#include <bit>
#include <cassert>
#include <cmath>
#include <cstring>

#include "coupler/base/error.hpp"

namespace sluice {
namespace {

static_assert(std::endian::native == std::endian::little, "frames are little endian; swap here for other machines");

std::uint64_t checksum_of(Header header, std::span<std::byte const> body)
{
    header.checksum = 0;
    auto const seed = XXH3_64bits(&header, sizeof header);
    return XXH3_64bits_withSeed(body.data(), body.size(), seed);
}

void seal(Bytes& message, Header header)
{
    header.body = message.size() - sizeof header;
    header.checksum = checksum_of(header, std::span(message).subspan(sizeof header));
    std::memcpy(message.data(), &header, sizeof header);
}

template <class T>
void append(Bytes& message, std::vector<T> const& values)
{
    auto const bytes = std::as_bytes(std::span(values));
    message.insert(message.end(), bytes.begin(), bytes.end());  // no zeros first, as resize() would write
}

//! Moves the first `count` values of `bytes` into `values`.
template <class T>
void take(std::span<std::byte const>& bytes, std::size_t count, std::vector<T>& values)
{
    values.resize(count);
    if (count > 0) std::memcpy(values.data(), bytes.data(), count * sizeof(T));
    bytes = bytes.subspan(count * sizeof(T));
}

template <class T>
bool same_bits(std::vector<T> const& a,
               std::vector<T> const& b)  // -0.0 and 0.0 differ: the receiver gets the same bits
{
    return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

void require_finite(Frame const& frame, std::size_t column, DataSpec const& spec, int width, std::string const& sender)
{
    auto const& values = frame.columns[column];
    constexpr std::uint64_t exponent = 0x7ff0'0000'0000'0000;  // all ones: infinite or not a number
    std::uint64_t bad = 0;
    for (double x : values) bad |= (std::bit_cast<std::uint64_t>(x) & exponent) == exponent;
    if (bad == 0) return;
    std::size_t at = 0;
    while (std::isfinite(values[at])) ++at;
    auto const id = frame.ids[at / static_cast<std::size_t>(width)];
    throw Error("participant \"" + sender + "\": " + spec.name + "." + spec.columns[column].name + " of id " +
                    std::to_string(id) + " is not finite in frame " + std::to_string(frame.index) +
                    " (nothing was sent). Look for a step that is too large.",
                Exit::numerical);
}

}  // namespace

Bytes encode_text(MessageKind kind, std::uint64_t session, std::int64_t window, std::string_view text,
                  std::uint32_t edge)
{
    Bytes message(sizeof(Header) + text.size());
    if (!text.empty()) std::memcpy(message.data() + sizeof(Header), text.data(), text.size());
    Header header;
    header.kind = kind;
    header.session = session;
    header.frame = window;
    header.edge = edge;
    seal(message, header);
    return message;
}

Header open_message(std::span<std::byte const> message, std::string const& sender)
{
    auto refuse = [&](std::string const& why) {
        throw Error("message from \"" + sender + "\": " + why + ". Do all participants run the same Sluice?",
                    Exit::protocol);
    };
    Header header;
    if (message.size() < sizeof header) refuse("shorter than a header");
    std::memcpy(&header, message.data(), sizeof header);
    if (header.magic != Header{}.magic) refuse("not a Sluice message");
    if (header.version != protocol_version)
        refuse("protocol version " + std::to_string(header.version) + " there, " + std::to_string(protocol_version) +
               " here");
    auto const body = message.subspan(sizeof header);
    if (header.body != body.size()) refuse("its length does not match its header");
    if (header.checksum != checksum_of(header, body)) refuse("its checksum is wrong");
    return header;
}

std::string text_of(std::span<std::byte const> message)
{
    auto const body = message.subspan(sizeof(Header));
    return {reinterpret_cast<char const*>(body.data()), body.size()};
}

std::span<std::byte const> FrameEncoder::encode(Frame& frame, std::uint64_t session, std::string const& sender)
{
    assert(frame.columns.size() == spec_.columns.size());
    Header header;
    header.kind = MessageKind::frame;
    header.session = session;
    header.edge = edge_;
    header.frame = frame.index;
    header.time = frame.time;
    header.points = static_cast<std::uint64_t>(frame.points());
    buffer_.resize(sizeof header);
    if (first_ || !same_bits(frame.ids, last_.ids)) {
        header.columns |= ids_bit;
        append(buffer_, frame.ids);
    }
    bool const all = first_ || frame.ids.size() != last_.ids.size();
    for (std::size_t c = 0; c < frame.columns.size(); ++c) {
        int const width = components(spec_.columns[c].shape, dimension_);
        assert(frame.columns[c].size() == frame.ids.size() * static_cast<std::size_t>(width));
        if (!all && same_bits(frame.columns[c], last_.columns[c])) continue;
        require_finite(frame, c, spec_, width, sender);
        header.columns |= 1u << c;
        append(buffer_, frame.columns[c]);
    }
    seal(buffer_, header);
    std::swap(last_, frame);
    first_ = false;
    return buffer_;
}

Frame FrameDecoder::decode(Header const& header, std::span<std::byte const> message, std::string const& sender)
{
    auto refuse = [&](std::string const& why) {
        throw Error("frame " + std::to_string(header.frame) + " of " + spec_.name + " from \"" + sender + "\": " + why +
                        ". Do all participants run the same Sluice?",
                    Exit::protocol);
    };
    auto body = message.subspan(sizeof(Header));
    bool const has_ids = header.columns & ids_bit;
    std::size_t const points = header.points;
    if (points > body.size() && points != last_.ids.size()) refuse("more points than bytes");
    if (!has_ids && points != last_.ids.size()) refuse("new points without ids");
    if ((header.columns & ~ids_bit) >> spec_.columns.size() != 0) refuse("columns that the data does not have");
    std::size_t expected = has_ids ? points * sizeof(std::int64_t) : 0;
    for (std::size_t c = 0; c < spec_.columns.size(); ++c) {
        auto const width = static_cast<std::size_t>(components(spec_.columns[c].shape, dimension_));
        if (header.columns & (1u << c))
            expected += points * width * sizeof(double);
        else if (c >= last_.columns.size() || last_.columns[c].size() != points * width)
            refuse("column " + spec_.columns[c].name + " is missing");
    }
    if (expected != body.size()) refuse("its columns and its length do not match");
    last_.index = header.frame;
    last_.time = header.time;
    last_.columns.resize(spec_.columns.size());
    if (has_ids) take(body, points, last_.ids);
    for (std::size_t c = 0; c < spec_.columns.size(); ++c) {
        auto const width = static_cast<std::size_t>(components(spec_.columns[c].shape, dimension_));
        if (header.columns & (1u << c)) take(body, points * width, last_.columns[c]);
    }
    return last_;
}

}  // namespace sluice
