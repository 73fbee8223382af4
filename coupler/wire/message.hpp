#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "coupler/base/data.hpp"
#include "coupler/base/frame.hpp"

namespace sluice {

//! Raised whenever bytes on the wire change their meaning; compared at handshake.
inline constexpr std::uint16_t protocol_version = 1;

using Bytes = std::vector<std::byte>;

enum class MessageKind : std::uint16_t
{
    hello = 1,  //!< body: text, see Session::greet()
    frame = 2,  //!< body: ids and columns
    abort = 3,  //!< body: text, why the sender stopped
    bye = 4,    //!< no body: the sender is done and has sent everything
    credit = 5  //!< no body: the receiver of `edge` has used its frame `frame`
};

//! 64 bytes, little endian, in front of every message.
struct Header
{
    std::uint32_t magic = 0x43554c53;  //!< "SLUC"
    std::uint16_t version = protocol_version;
    MessageKind kind = MessageKind::bye;
    std::uint64_t session = 0;  //!< of the run; 0 in a hello
    std::uint32_t edge = 0;     //!< index into Scene::edges
    std::uint32_t columns = 0;  //!< bit c: column c follows; bit 31: ids follow
    std::int64_t frame = 0;     //!< its number; in an abort the sender's window
    double time = 0;            //!< s
    std::uint64_t points = 0;
    std::uint64_t body = 0;      //!< bytes after the header
    std::uint64_t checksum = 0;  //!< XXH3 of header (this field 0) and body
};
static_assert(sizeof(Header) == 64);

inline constexpr std::uint32_t ids_bit = 1u << 31;

//! A header and a text body as one message.
Bytes encode_text(MessageKind kind, std::uint64_t session, std::int64_t window, std::string_view text,
                  std::uint32_t edge = 0);

//! The header of a message if its magic, version, length and checksum are right.
//! Throws Error (exit 5) with the sender's name otherwise; nothing is allocated before.
Header open_message(std::span<std::byte const> message, std::string const& sender);
std::string text_of(std::span<std::byte const> message);

//! Writes the frames of one out-edge: what did not change since the last frame is not written again.
class FrameEncoder
{
 public:
    FrameEncoder(DataSpec spec, int dimension, std::uint32_t edge)
        : spec_(std::move(spec)), dimension_(dimension), edge_(edge)
    {}

    //! The bytes of `frame`, valid until the next call. `frame` is exchanged for the one before it, to be overwritten.
    //! Throws Error (exit 6) on a number that is not finite, naming the column, the id and the frame, and asserts that
    //! every column has points * components values.
    std::span<std::byte const> encode(Frame& frame, std::uint64_t session, std::string const& sender);

 private:
    DataSpec spec_;
    int dimension_;
    std::uint32_t edge_;
    Frame last_;
    bool first_ = true;
    Bytes buffer_;
};

//! Reads the frames of one in-edge, filling columns that did not travel from the frame before.
class FrameDecoder
{
 public:
    FrameDecoder(DataSpec spec, int dimension) : spec_(std::move(spec)), dimension_(dimension) {}

    //! `message` has passed open_message(). Throws Error (exit 5) if its columns and length do not fit the data.
    Frame decode(Header const& header, std::span<std::byte const> message, std::string const& sender);

 private:
    DataSpec spec_;
    int dimension_;
    Frame last_;
};

}  // namespace sluice
