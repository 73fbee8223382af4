#include "coupler/base/checksum.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <vector>

using namespace sluice;

namespace {

std::span<std::byte const> bytes(std::string_view text)
{
    return std::as_bytes(std::span(text));
}

}  // namespace

TEST_CASE("checksum: known values of XXH3")
{
    // Source: xxhash 0.8, XXH3 of no bytes with seed 0; `xxhsum -H2` and `-H3` print the same
    CHECK(hex(digest_of({})) == "99aa06d3014798d86001c324468d497f");
    CHECK(hex(checksum_of({})) == "2d06800538d394c2");
    CHECK(digest_of(bytes("a")) != digest_of(bytes("b")));
    CHECK(digest_of(bytes("a"), 1) != digest_of(bytes("a")));
}

TEST_CASE("checksum: pieces give the digest of the whole")
{
    std::vector<std::byte> data(100'000);
    for (std::size_t i = 0; i < data.size(); ++i) data[i] = static_cast<std::byte>(i * 7 + i / 256);
    for (std::size_t piece : {1u, 63u, 4096u, 99'999u}) {
        DigestStream stream;
        for (std::size_t at = 0; at < data.size(); at += piece)
            stream.add(std::span(data).subspan(at, std::min(piece, data.size() - at)));
        CHECK(stream.digest() == digest_of(data));
    }
    CHECK(DigestStream().digest() == digest_of({}));
}

TEST_CASE("checksum: hexadecimal digits and back, and nothing else")
{
    Digest const digest{0x0123'4567'89ab'cdef, 0xf};
    CHECK(hex(digest) == "0123456789abcdef000000000000000f");
    CHECK(digest_from_hex(hex(digest)) == digest);
    CHECK(from_hex(hex(std::uint64_t{0})) == 0u);
    for (char const* wrong : {"", "0123456789abcde", "0123456789abcdeg", "0123456789ABCDEF", "+123456789abcdef",
                              "00123456789abcdef", "0x23456789abcdef"})
        CHECK_FALSE(from_hex(wrong));
    CHECK_FALSE(digest_from_hex("0123456789abcdef"));
    CHECK_FALSE(digest_from_hex("0123456789abcdef000000000000000g"));
}
