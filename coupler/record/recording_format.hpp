#pragma once

#include <bit>
#include <cstdint>
#include <span>

#include "coupler/base/checksum.hpp"

//! The bytes of a recording, shared by its writer and its reader. Little endian.
namespace sluice::recording {

static_assert(std::endian::native == std::endian::little, "recordings are little endian; swap here for other machines");

inline constexpr std::uint64_t longest_canonical = 64u << 20;  //!< B
inline constexpr std::uint32_t end_mark = 0xffff'ffff;         //!< as an edge: no record follows; frame: how many came

struct FileHead
{
    std::uint64_t magic = 0x4345524349554c53;  //!< "SLUICREC"
    std::uint32_t version = 1;
    std::uint32_t unused = 0;
    std::uint64_t scene = 0;
    std::uint64_t canonical = 0;  //!< B that follow
    std::uint64_t text_checksum = 0;
    std::uint64_t zero[2] = {};
    std::uint64_t checksum = 0;  //!< of this head, this field 0
};
static_assert(sizeof(FileHead) == 64);

struct RecordHead
{
    std::uint32_t magic = 0x44434552;  //!< "RECD"
    std::uint32_t edge = 0;
    std::int64_t frame = 0;
    std::uint64_t length = 0;  //!< B that follow
    std::uint64_t body_checksum = 0;
    std::uint64_t checksum = 0;  //!< of this head, this field 0: a length that can be trusted tells a cut from damage
};
static_assert(sizeof(RecordHead) == 40);

template <class Head>
std::uint64_t checksum_of_head(Head head)
{
    head.checksum = 0;
    return checksum_of(std::as_bytes(std::span(&head, 1)));
}

}  // namespace sluice::recording
