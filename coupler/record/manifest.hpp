#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "coupler/base/checksum.hpp"

namespace sluice {

//! What one process of the run wrote of a checkpoint, and reports to the coordinator.
struct CheckpointPart
{
    std::string member;  //!< "grains", or "water:3" for rank 3 of several
    std::uint64_t bytes = 0;
    Digest digest;
    bool operator==(CheckpointPart const&) const = default;

    //! `member bytes digest`, as a message's text, and back: nothing unless it is exactly that.
    std::string line() const;
    static std::optional<CheckpointPart> parse(std::string_view line);
};

//! A participant's name (1 to 64 letters, digits, _ and -), or one followed by `:` and a rank.
bool is_member(std::string_view name);

//! What makes a checkpoint complete: who wrote what of it. Written last, as JSON that a person can read.
struct Manifest
{
    std::string version;                   //!< of Sluice
    std::uint64_t scene = 0;               //!< its hash
    std::int64_t window = 0;               //!< windows done
    std::int64_t ticks = 0;                //!< simulated time
    double tick = 0;                       //!< s, > 0
    std::optional<std::int64_t> previous;  //!< window of the generation before
    std::vector<CheckpointPart> members;   //!< by name
    bool operator==(Manifest const&) const = default;

    static constexpr std::size_t most_members = 65'536;
    static constexpr std::size_t longest_text = 16u << 20;  //!< B

    CheckpointPart const* part_of(std::string_view member) const;  //!< null: it has none

    //! One content has one text. Throws Error (exit 70) if a member is no name or there twice, or a number is out of
    //! its range.
    std::string text() const;
    //! Takes exactly what text() returns; throws Error (exit 7) that starts with `where` otherwise.
    static Manifest parse(std::string_view text, std::string const& where);
};

}  // namespace sluice
