#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "coupler/base/checksum.hpp"
#include "coupler/base/data.hpp"
#include "coupler/base/frame.hpp"

namespace sluice {

//! Raised whenever bytes on the wire change their meaning; compared at handshake.
inline constexpr std::uint16_t protocol_version = 3;

using Bytes = std::vector<std::byte>;

enum class MessageKind : std::uint16_t
{
    hello = 1,    //!< body: text, see handshake.cpp
    frame = 2,    //!< body: see message.cpp
    abort = 3,    //!< body: text, why the sender stopped
    bye = 4,      //!< no body: the sender is done and has sent everything
    credit = 5,   //!< no body: the receiver of `edge` has used its frame `frame`
    plan = 6,     //!< no body: window `frame` begins at `ticks`, has length `points`, flags in `columns`
    verdict = 7,  //!< body: numbers, one member's share of what decides on another iteration of window `frame`
    request = 8,  //!< no body: to the one who paces the run: `columns` says what is wanted
    stored = 9,   //!< body: text, one member's part of checkpoint `frame` is on its disk
    power = 10    //!< body: numbers, what the sender reckons that frame `frame` of `edge`, which follows, gives
};

//! 64 bytes, little endian, in front of every message.
struct Header
{
    std::uint32_t magic = 0x43554c53;  //!< "SLUC"
    std::uint16_t version = protocol_version;
    MessageKind kind = MessageKind::bye;
    std::uint64_t session = 0;    //!< of the run; 0 in a hello
    std::uint32_t edge = 0;       //!< index into Scene::edges
    std::uint32_t columns = 0;    //!< bit c: column c follows; bit 31: ids follow
    std::int64_t frame = 0;       //!< its number; in an abort the sender's window
    std::int64_t ticks = 0;       //!< time, see base/ticks.hpp
    std::uint32_t points = 0;     //!< of a frame
    std::uint32_t iteration = 0;  //!< of the window, in an implicit group
    std::uint64_t body = 0;       //!< bytes after the header
    std::uint64_t checksum = 0;   //!< XXH3 of the header (this field 0) and what stands behind it, see message.cpp
};
static_assert(sizeof(Header) == 64);

inline constexpr std::uint32_t ids_bit = 1u << 31;

//! Fills in length and checksum of a message without a body.
void seal(Header& header);
std::span<std::byte const> bytes_of(Header const& header);
//! A header and a body as one message.
Bytes encode(Header header, std::span<std::byte const> body);
Bytes encode_text(Header const& header, std::string_view text);

//! The header of a message if its magic, version, length and checksum are right.
//! Throws Error (exit 5) with the sender's name otherwise; nothing is allocated before.
Header open_message(std::span<std::byte const> message, std::string const& sender);
std::string text_of(std::span<std::byte const> message);
//! The body as numbers; what does not fill one is left out.
std::vector<double> numbers_of(std::span<std::byte const> message);

//! What a sender wants to send on an edge.
struct Outgoing
{
    std::int64_t index = 0;
    std::int64_t ticks = 0;
    std::uint32_t iteration = 0;
    std::span<std::int64_t const> ids;
    std::span<std::span<double const> const> columns;  //!< each points * components numbers
};

//! Writes the frames of one out-edge to one receiver: what did not change since the last frame is not written again.
class FrameEncoder
{
 public:
    //! `wanted`: bit c set: the receiver reads column c.
    FrameEncoder(DataSpec spec, int dimension, std::uint32_t edge, std::uint32_t wanted = ~0u);

    //! The most bytes that a frame of so many points can take.
    std::size_t bound(std::size_t points) const;
    //! Writes a frame into `room` (at least bound() bytes, 64-byte aligned) and returns how many bytes it takes.
    //! One pass: numbers are copied, looked at and hashed block by block. Throws Error (exit 6) on a number that is not
    //! finite, naming the column, the id and the frame; asserts that every column has points * components values.
    std::size_t encode(Outgoing const& frame, std::uint64_t session, std::string const& sender,
                       std::span<std::byte> room);
    //! The next frame is sent whole.
    void forget() { last_.clear(); }

 private:
    DataSpec spec_;
    int dimension_;
    std::uint32_t edge_;
    std::uint32_t wanted_;
    std::vector<Digest> last_;  //!< of the columns of the last frame, then of its ids; empty: nothing was sent
};

//! Reads the frames of one in-edge from one sender, filling columns that did not travel from the frame before.
class FrameDecoder
{
 public:
    //! `wanted`: bit c set: column c is read; others stay empty.
    FrameDecoder(DataSpec spec, int dimension, std::uint32_t wanted = ~0u);

    //! `message` has passed open_message() and is held by `owner`: the frame looks into it. Throws Error (exit 5) if
    //! its columns and length do not fit the data, or a column's hash is wrong.
    Frame decode(Header const& header, std::span<std::byte const> message, std::shared_ptr<void const> const& owner,
                 std::string const& sender);

 private:
    std::size_t width(std::size_t column) const;

    DataSpec spec_;
    int dimension_;
    std::uint32_t wanted_;
    Frame last_;
    std::vector<char> own_;  //!< per column, then ids: what last_ holds is a copy of our own, not a message's
};

}  // namespace sluice
