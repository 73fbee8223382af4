#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace sluice {

//! A state's bytes in pieces: some are in `heads`, some are views of the state's arrays, which must not change
//! meanwhile.
struct StatePieces
{
    StatePieces() = default;
    StatePieces(StatePieces&&) = default;  // a copy would view the other one's heads
    StatePieces& operator=(StatePieces&&) = default;
    std::vector<std::byte> heads;
    std::vector<std::span<std::byte const>> pieces;
};

//! All that a solver needs to go on bit for bit: arrays of float64, int64 or bytes by name, in the names' order. As
//! bytes, one content has one encoding, whatever the order it was put in:
//!
//!     head      64 B   magic, version, number of arrays, length, XXH3-128 of everything else
//!     array     16 B   type (0 numbers, 1 integers, 2 bytes), length of the name, length of the data [B]
//!               name, zeros up to a multiple of 64 B, data, zeros up to a multiple of 64 B
//!
//! A name has 1 to 200 letters, digits, `_ - . : /`.
class State
{
 public:
    //! Copies the values. Throws Error (exit 70) if the name is taken or no name.
    void put(std::string_view name, std::span<double const> numbers);
    void put(std::string_view name, std::span<std::int64_t const> integers);
    void put(std::string_view name, std::span<std::byte const> bytes);
    void put_number(std::string_view name, double number) { put(name, std::span<double const>(&number, 1)); }
    void put_integer(std::string_view name, std::int64_t integer)
    {
        put(name, std::span<std::int64_t const>(&integer, 1));
    }
    void put_text(std::string_view name, std::string_view text) { put(name, std::as_bytes(std::span(text))); }

    //! What was put; views live as long as this state. Each throws Error (exit 7) that names the array if it is not
    //! there, has another type, or (number, integer) has not exactly one value.
    std::span<double const> numbers(std::string_view name) const;
    std::span<std::int64_t const> integers(std::string_view name) const;
    std::span<std::byte const> bytes(std::string_view name) const;
    double number(std::string_view name) const;
    std::int64_t integer(std::string_view name) const;
    std::string text(std::string_view name) const;
    //! The same for arrays that must have `size` values.
    std::span<double const> numbers(std::string_view name, std::size_t size) const;
    std::span<std::int64_t const> integers(std::string_view name, std::size_t size) const;

    bool has(std::string_view name) const { return arrays_.contains(name); }
    std::size_t size() const { return arrays_.size(); }
    bool operator==(State const& other) const;  //!< bit for bit: NaN equals itself, 0.0 is not -0.0

    //! Moves every array of `inner` in here as `prefix/name`; `take` moves them out again.
    void nest(std::string_view prefix, State inner);
    State take(std::string_view prefix);

    std::vector<std::byte> encode() const;
    //! The bytes of encode(), in order, without a copy of the arrays.
    StatePieces pieces() const;
    //! Throws Error (exit 7) that starts with `where` for anything that encode() did not write; nothing is allocated
    //! before the length and the checksum are right. `where` also stands in later messages about what is missing.
    static State decode(std::span<std::byte const> encoded, std::string where);

 private:
    using Array = std::variant<std::vector<double>, std::vector<std::int64_t>, std::vector<std::byte>>;
    template <class Value>
    void insert(std::string_view name, std::span<Value const> values);
    template <class Value>
    std::vector<Value> const& find(std::string_view name) const;
    template <class Value>
    std::vector<Value> const& find(std::string_view name, std::size_t size) const;

    std::map<std::string, Array, std::less<>> arrays_;
    std::string where_ = "state";
};

inline constexpr std::size_t longest_state_name = 200;
bool is_state_name(std::string_view name);

}  // namespace sluice
