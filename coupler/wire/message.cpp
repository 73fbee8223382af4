#include "coupler/wire/message.hpp"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstring>

#include "coupler/base/error.hpp"

namespace sluice {
namespace {

static_assert(std::endian::native == std::endian::little, "frames are little endian; swap here for other machines");

// A frame's body: one Digest for each column that follows, then the ids if they follow, at the end of this table; zeros
// up to a multiple of 64 bytes from the message's beginning; then ids and columns, each padded likewise. The checksum
// covers header and table, the hashes in the table cover the rest.

constexpr std::size_t line = 64;          // bytes
constexpr std::size_t block = 16 * 1024;  // bytes copied, looked at and hashed while they are in the first cache
constexpr std::size_t most_columns = 31;

constexpr std::size_t padded(std::size_t bytes)
{
    return (bytes + line - 1) / line * line;
}

std::size_t table_size(std::uint32_t columns)
{
    return static_cast<std::size_t>(std::popcount(columns)) * sizeof(Digest);
}

//! What the checksum of a message covers besides its header.
std::span<std::byte const> covered(Header const& header, std::span<std::byte const> body)
{
    if (header.kind != MessageKind::frame) return body;
    return body.first(std::min(body.size(), table_size(header.columns)));
}

std::uint64_t checksum_with(Header header, std::span<std::byte const> rest)
{
    header.checksum = 0;
    return checksum_of(rest, checksum_of(bytes_of(header)));
}

//! Copies `count` numbers and says whether one of them is not finite.
bool copy_looking(double const* __restrict from, double* __restrict to, std::size_t count)
{
    constexpr std::uint64_t exponent = 0x7ff0'0000'0000'0000;  // all ones: infinite or not a number
    std::uint64_t bad = 0;
    for (std::size_t i = 0; i < count; ++i) {
        to[i] = from[i];
        bad |= (std::bit_cast<std::uint64_t>(from[i]) & exponent) == exponent;
    }
    return bad != 0;
}

bool copy_looking(std::int64_t const* __restrict from, std::int64_t* __restrict to, std::size_t count)
{
    std::memcpy(to, from, count * sizeof *from);
    return false;
}

//! Copies numbers into a message and returns their hash; nothing if one of them is not finite.
template <class T>
std::optional<Digest> copy_hashing(std::span<T const> from, std::byte* to)
{
    auto* const target = reinterpret_cast<T*>(to);
    constexpr std::size_t numbers = block / sizeof(T);
    if (from.size() <= numbers) {
        if (from.empty()) return digest_of({});
        if (copy_looking(from.data(), target, from.size())) return std::nullopt;
        return digest_of(std::as_bytes(std::span(target, from.size())));
    }
    DigestStream stream;
    for (std::size_t i = 0; i < from.size(); i += numbers) {
        auto const count = std::min(numbers, from.size() - i);
        if (copy_looking(from.data() + i, target + i, count)) return std::nullopt;
        stream.add(std::as_bytes(std::span(target + i, count)));
    }
    return stream.digest();
}

[[noreturn]] void refuse_number(Outgoing const& frame, std::size_t column, DataSpec const& spec, std::size_t width,
                                std::string const& sender)
{
    std::size_t at = 0;
    while (std::isfinite(frame.columns[column][at])) ++at;
    throw Error("participant \"" + sender + "\": " + spec.name + "." + spec.columns[column].name + " of id " +
                    std::to_string(frame.ids[at / width]) + " is not finite in frame " + std::to_string(frame.index) +
                    " (nothing was sent). Look for a step that is too large.",
                Exit::numerical);
}

}  // namespace

void seal(Header& header)
{
    header.body = 0;
    header.checksum = checksum_with(header, {});
}

std::span<std::byte const> bytes_of(Header const& header)
{
    return std::as_bytes(std::span(&header, 1));
}

Bytes encode(Header header, std::span<std::byte const> body)
{
    Bytes message(sizeof header + body.size());
    if (!body.empty()) std::memcpy(message.data() + sizeof header, body.data(), body.size());
    header.body = body.size();
    header.checksum = checksum_with(header, body);
    std::memcpy(message.data(), &header, sizeof header);
    return message;
}

Bytes encode_text(Header const& header, std::string_view text)
{
    return encode(header, std::as_bytes(std::span(text)));
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
    if (!checksum_fits(header.checksum, checksum_with(header, covered(header, body)))) refuse("its checksum is wrong");
    return header;
}

std::string text_of(std::span<std::byte const> message)
{
    auto const body = message.subspan(sizeof(Header));
    return {reinterpret_cast<char const*>(body.data()), body.size()};
}

std::vector<double> numbers_of(std::span<std::byte const> message)
{
    auto const body = message.subspan(sizeof(Header));
    std::vector<double> numbers(body.size() / sizeof(double));
    if (!numbers.empty()) std::memcpy(numbers.data(), body.data(), numbers.size() * sizeof(double));
    return numbers;
}

FrameEncoder::FrameEncoder(DataSpec spec, int dimension, std::uint32_t edge, std::uint32_t wanted)
    : spec_(std::move(spec)), dimension_(dimension), edge_(edge), wanted_(wanted)
{
    assert(spec_.columns.size() < most_columns);
}

std::size_t FrameEncoder::bound(std::size_t points) const
{
    std::size_t size = padded(sizeof(Header) + (spec_.columns.size() + 1) * sizeof(Digest));
    size += padded(points * sizeof(std::int64_t));
    for (auto const& column : spec_.columns)
        size += padded(points * static_cast<std::size_t>(components(column.shape, dimension_)) * sizeof(double));
    return size;
}

std::size_t FrameEncoder::encode(Outgoing const& frame, std::uint64_t session, std::string const& sender,
                                 std::span<std::byte> room)
{
    auto const count = spec_.columns.size();
    assert(frame.columns.size() == count && room.size() >= bound(frame.ids.size()));
    Header header;
    header.kind = MessageKind::frame;
    header.session = session;
    header.edge = edge_;
    header.frame = frame.index;
    header.ticks = frame.ticks;
    header.iteration = frame.iteration;
    header.points = static_cast<std::uint32_t>(frame.ids.size());
    bool const first = last_.empty();
    last_.resize(count + 1);
    // Numbers are written behind the largest table; the table that is needed is at most as large, and what follows it
    // stays where it is: the padding in between is part of the message.
    std::size_t const begin = padded(sizeof header + (count + 1) * sizeof(Digest));
    std::size_t end = begin;
    std::array<Digest, most_columns + 1> table;
    std::size_t entries = 0;
    auto put = [&](std::size_t slot, std::optional<Digest> const& hash, std::uint32_t bit, std::size_t bytes) {
        if (!first && last_[slot] == *hash) return;
        last_[slot] = *hash;
        table[entries++] = *hash;
        header.columns |= bit;
        std::memset(room.data() + end + bytes, 0, padded(bytes) - bytes);
        end += padded(bytes);
    };
    put(count, copy_hashing(frame.ids, room.data() + end), ids_bit, frame.ids.size_bytes());
    for (std::size_t c = 0; c < count; ++c) {
        if (!(wanted_ & (1u << c))) continue;
        auto const width = static_cast<std::size_t>(components(spec_.columns[c].shape, dimension_));
        assert(frame.columns[c].size() == frame.ids.size() * width);
        auto const hash = copy_hashing(frame.columns[c], room.data() + end);
        if (!hash) {
            last_.clear();
            refuse_number(frame, c, spec_, width, sender);
        }
        put(c, hash, 1u << c, frame.columns[c].size_bytes());
    }
    if (entries == 0) end = sizeof header;
    auto* const behind = room.data() + sizeof header;
    std::memcpy(behind, table.data(), entries * sizeof(Digest));
    if (end > sizeof header)
        std::memset(behind + entries * sizeof(Digest), 0, begin - sizeof header - entries * sizeof(Digest));
    header.body = end - sizeof header;
    header.checksum = checksum_with(header, {behind, entries * sizeof(Digest)});
    std::memcpy(room.data(), &header, sizeof header);
    return end;
}

FrameDecoder::FrameDecoder(DataSpec spec, int dimension, std::uint32_t wanted)
    : spec_(std::move(spec)), dimension_(dimension), wanted_(wanted), own_(spec_.columns.size() + 1)
{
    last_.columns.resize(spec_.columns.size());
}

std::size_t FrameDecoder::width(std::size_t column) const
{
    return static_cast<std::size_t>(components(spec_.columns[column].shape, dimension_));
}

namespace {

bool all_zero(std::span<std::byte const> bytes)
{
    return std::all_of(bytes.begin(), bytes.end(), [](std::byte b) { return b == std::byte{0}; });
}

//! Where the parts of a frame's body are, looked at before anything is taken from them.
class Parts
{
 public:
    Parts(Header const& header, std::span<std::byte const> message, std::size_t columns)
        : message_(message), begin_(padded(sizeof(Header) + (columns + 1) * sizeof(Digest)))
    {
        if (header.columns != 0) at_ = begin_;
    }

    //! The next `bytes` bytes, if they are there and have the hash that the table says.
    std::optional<std::span<std::byte const>> next(std::size_t bytes, char const*& why)
    {
        if (at_ > message_.size() || padded(bytes) > message_.size() - at_) {
            why = "its columns and its length do not match";
            return std::nullopt;
        }
        auto const part = message_.subspan(at_, bytes);
        Digest said;
        std::memcpy(&said, message_.data() + table_, sizeof said);
        if (!checksum_fits(said, digest_of(part)) || !all_zero(message_.subspan(at_ + bytes, padded(bytes) - bytes))) {
            why = "the hash of a column is wrong";
            return std::nullopt;
        }
        table_ += sizeof said;
        at_ += padded(bytes);
        return part;
    }
    bool whole() const
    {
        auto const table_end = message_.size() > sizeof(Header) ? begin_ : table_;
        return at_ == message_.size() && all_zero(message_.subspan(table_, table_end - table_));
    }

 private:
    std::span<std::byte const> message_;
    std::size_t begin_;                   //!< of the first column
    std::size_t table_ = sizeof(Header);  //!< the next entry of the table
    std::size_t at_ = sizeof(Header);     //!< the next column
};

//! Numbers where they stand in a message, or a copy where they do not stand aligned.
template <class T>
Held<T> held(std::span<std::byte const> part, std::shared_ptr<void const> const& owner, char& own)
{
    own = reinterpret_cast<std::uintptr_t>(part.data()) % alignof(T) != 0;
    auto const count = part.size() / sizeof(T);
    if (!own) return {{reinterpret_cast<T const*>(part.data()), count}, owner};
    std::vector<T> copy(count);
    if (count > 0) std::memcpy(copy.data(), part.data(), part.size());
    return Held<T>::of(std::move(copy));
}

}  // namespace

Frame FrameDecoder::decode(Header const& header, std::span<std::byte const> message,
                           std::shared_ptr<void const> const& owner, std::string const& sender)
{
    auto refuse = [&](std::string const& why) {
        throw Error("frame " + std::to_string(header.frame) + " of " + spec_.name + " from \"" + sender + "\": " + why +
                        ". Do all participants run the same Sluice?",
                    Exit::protocol);
    };
    auto const count = spec_.columns.size();
    std::size_t const points = header.points;
    bool const has_ids = header.columns & ids_bit;
    if ((header.columns & ~ids_bit) >> count != 0) refuse("columns that the data does not have");
    if (!has_ids && points != last_.points()) refuse("new points without ids");
    for (std::size_t c = 0; c < count; ++c) {
        bool const here = header.columns & (1u << c), needed = wanted_ & (1u << c);
        if (here && !needed) refuse("column " + spec_.columns[c].name + " that is not read");
        if (needed && !here && last_.columns[c].values.size() != points * width(c))
            refuse("column " + spec_.columns[c].name + " is missing");
    }
    Parts parts(header, message, count);
    char const* why = nullptr;
    Frame frame = last_;
    auto own = own_;
    frame.index = header.frame;
    frame.ticks = header.ticks;
    frame.iteration = header.iteration;
    auto next = [&](std::size_t bytes) {
        auto const part = parts.next(bytes, why);
        if (!part) refuse(why);
        return *part;
    };
    if (has_ids) frame.ids = held<std::int64_t>(next(points * sizeof(std::int64_t)), owner, own[count]);
    for (std::size_t c = 0; c < count; ++c)
        if (header.columns & (1u << c))
            frame.columns[c] = held<double>(next(points * width(c) * sizeof(double)), owner, own[c]);
    if (!parts.whole()) refuse("its columns and its length do not match");
    // What did not travel is kept from now on in a copy of ours: its message's memory goes back to the transport.
    if (!has_ids && !own[count]) {
        frame.ids = Held<std::int64_t>::copy_of(frame.ids.values);
        own[count] = true;
    }
    for (std::size_t c = 0; c < count; ++c)
        if (!(header.columns & (1u << c)) && !own[c] && (wanted_ & (1u << c))) {
            frame.columns[c] = Held<double>::copy_of(frame.columns[c].values);
            own[c] = true;
        }
    own_ = std::move(own);
    last_ = frame;
    return frame;
}

}  // namespace sluice
