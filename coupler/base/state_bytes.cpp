#include <algorithm>
#include <bit>
#include <cstring>

#include "coupler/base/checksum.hpp"
#include "coupler/base/error.hpp"
#include "coupler/base/state.hpp"

namespace sluice {
namespace {

static_assert(std::endian::native == std::endian::little, "states are little endian; swap here for other machines");

struct Head
{
    std::uint64_t magic = 0x4554415453554c53;  //!< "SLUSTATE"
    std::uint32_t version = 1;
    std::uint32_t reserved = 0;
    std::uint64_t arrays = 0;
    std::uint64_t length = 0;  //!< B, this head included
    Digest digest;             //!< of everything, this field 0
    std::uint64_t unused[2] = {};
};
static_assert(sizeof(Head) == 64);

struct ArrayHead
{
    std::uint32_t type = 0;
    std::uint32_t name = 0;  //!< B
    std::uint64_t data = 0;  //!< B
};
static_assert(sizeof(ArrayHead) == 16);

constexpr std::size_t alignment = 64;
constexpr std::size_t widths[] = {sizeof(double), sizeof(std::int64_t), 1};

constexpr std::size_t padded(std::size_t size)
{
    return (size + alignment - 1) / alignment * alignment;
}

Digest digest_of_all(Head head, std::span<std::byte const> rest)
{
    head.digest = {};
    return digest_of(rest, checksum_of(std::as_bytes(std::span(&head, 1))));
}

template <class Array>
std::span<std::byte const> bytes_of(Array const& array)
{
    return std::visit([](auto const& values) { return std::as_bytes(std::span(values)); }, array);
}

void append(std::vector<std::byte>& to, std::span<std::byte const> bytes)
{
    to.insert(to.end(), bytes.begin(), bytes.end());
}

//! Writes the head with the digest of everything to where it stands, the begin of the first piece.
void seal(Head head, StatePieces& made)
{
    DigestStream stream(checksum_of(std::as_bytes(std::span(&head, 1))));
    bool first = true;
    for (auto const piece : made.pieces) {
        stream.add(first ? piece.subspan(sizeof head) : piece);
        first = false;
    }
    head.digest = stream.digest();
    std::memcpy(made.heads.data(), &head, sizeof head);
}

//! What follows the head, array by array.
class Entries
{
 public:
    Entries(std::span<std::byte const> rest, std::string const& where) : rest_(rest), where_(where) {}

    struct Entry
    {
        std::uint32_t type;
        std::string name;
        std::span<std::byte const> data;
    };
    Entry next()
    {
        ArrayHead head;
        auto const line = take(sizeof head);
        std::memcpy(&head, line.data(), sizeof head);
        if (head.type >= std::size(widths)) refuse("an array of unknown type");
        if (head.name > longest_state_name) refuse("a name that is too long");
        auto const text = take(head.name);
        Entry entry{head.type, std::string(reinterpret_cast<char const*>(text.data()), text.size()), {}};
        if (!is_state_name(entry.name)) refuse("an array whose name is none");
        if (!previous_.empty() && entry.name <= previous_) refuse("arrays out of order");
        skip_zeros();
        if (head.data % widths[head.type] != 0) refuse("an array with a part of a value");
        entry.data = take(head.data);
        skip_zeros();
        previous_ = entry.name;
        return entry;
    }
    bool done() const { return rest_.empty(); }

 private:
    [[noreturn]] void refuse(std::string const& why) const
    {
        throw Error(where_ + ": " + why + " (needs a state as Sluice writes it). Use another checkpoint.", Exit::io);
    }
    std::span<std::byte const> take(std::uint64_t bytes)
    {
        if (bytes > rest_.size()) refuse("an array that is longer than the state");
        auto const taken = rest_.first(bytes);
        rest_ = rest_.subspan(bytes);
        used_ += bytes;
        return taken;
    }
    void skip_zeros()
    {
        auto const gap = take(padded(used_) - used_);
        if (std::any_of(gap.begin(), gap.end(), [](std::byte b) { return b != std::byte{}; }))
            refuse("a gap with data");
    }

    std::span<std::byte const> rest_;
    std::string const& where_;
    std::size_t used_ = 0;
    std::string previous_;
};

template <class Value>
std::vector<Value> values_of(std::span<std::byte const> data)
{
    std::vector<Value> values(data.size() / sizeof(Value));
    if (!data.empty()) std::memcpy(values.data(), data.data(), data.size());
    return values;
}

template <>
std::vector<std::byte> values_of(std::span<std::byte const> data)
{
    return {data.begin(), data.end()};
}

}  // namespace

//! `heads` gets all that is not data, each stretch up to the next data; spans are made once it no longer grows.
StatePieces State::pieces() const
{
    Head head;
    head.arrays = arrays_.size();
    head.length = sizeof head;
    StatePieces made;
    made.heads.resize(sizeof head);
    std::vector<std::size_t> ends;  // of the stretches in `heads`
    for (auto const& [name, array] : arrays_) {
        auto const data = bytes_of(array).size();
        ArrayHead const line{static_cast<std::uint32_t>(array.index()), static_cast<std::uint32_t>(name.size()), data};
        append(made.heads, std::as_bytes(std::span(&line, 1)));
        append(made.heads, std::as_bytes(std::span(name)));
        std::size_t const before = sizeof line + name.size();
        made.heads.resize(made.heads.size() + padded(before) - before);
        ends.push_back(made.heads.size());
        made.heads.resize(made.heads.size() + padded(data) - data);
        head.length += padded(before) + padded(data);
    }
    std::size_t at = 0, array_number = 0;
    for (auto const& entry : arrays_) {
        std::size_t const end = ends[array_number++];
        made.pieces.push_back(std::span<std::byte const>(made.heads).subspan(at, end - at));
        made.pieces.push_back(bytes_of(entry.second));
        at = end;
    }
    made.pieces.push_back(std::span<std::byte const>(made.heads).subspan(at));
    seal(head, made);
    return made;
}

std::vector<std::byte> State::encode() const
{
    auto const made = pieces();
    std::size_t size = 0;
    for (auto const piece : made.pieces) size += piece.size();
    std::vector<std::byte> encoded;
    encoded.reserve(size);
    for (auto const piece : made.pieces) append(encoded, piece);
    return encoded;
}

State State::decode(std::span<std::byte const> encoded, std::string where)
{
    auto refuse = [&](std::string const& why) {
        throw Error(where + ": " + why + " (needs a state as Sluice writes it). Use another checkpoint.", Exit::io);
    };
    Head head;
    if (encoded.size() < sizeof head) refuse("shorter than a state's head");
    std::memcpy(&head, encoded.data(), sizeof head);
    auto const rest = encoded.subspan(sizeof head);
    if (head.magic != Head{}.magic) refuse("not a state");
    if (head.version != Head{}.version)
        refuse("version " + std::to_string(head.version) + " of the format, not " + std::to_string(Head{}.version));
    if (head.length != encoded.size()) refuse("its length is not the one it states");
    if (head.reserved != 0 || head.unused[0] != 0 || head.unused[1] != 0) refuse("a gap with data");
    if (!checksum_fits(head.digest, digest_of_all(head, rest))) refuse("its checksum is wrong");
    State state;
    Entries entries(rest, where);
    for (std::uint64_t i = 0; i < head.arrays; ++i) {
        auto entry = entries.next();  // throws where the bytes end, so that a false count ends too
        auto& array = state.arrays_[std::move(entry.name)];
        if (entry.type == 0) array = values_of<double>(entry.data);
        if (entry.type == 1) array = values_of<std::int64_t>(entry.data);
        if (entry.type == 2) array = values_of<std::byte>(entry.data);
    }
    if (!entries.done()) refuse("more bytes than arrays");
    state.where_ = std::move(where);
    return state;
}

}  // namespace sluice
