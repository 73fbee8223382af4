#include "coupler/base/checksum.hpp"

#define XXH_INLINE_ALL  // compiled here, for the vector registers that this build may use
#include <xxhash.h>

#include <charconv>
#include <new>

namespace sluice {

Digest digest_of(std::span<std::byte const> bytes, std::uint64_t seed)
{
    auto const hash = XXH3_128bits_withSeed(bytes.data(), bytes.size(), seed);
    return {hash.high64, hash.low64};
}

std::uint64_t checksum_of(std::span<std::byte const> bytes, std::uint64_t seed)
{
    return XXH3_64bits_withSeed(bytes.data(), bytes.size(), seed);
}

DigestStream::DigestStream(std::uint64_t seed) : state_(XXH3_createState())
{
    if (!state_) throw std::bad_alloc();
    XXH3_128bits_reset_withSeed(static_cast<XXH3_state_t*>(state_), seed);
}

DigestStream::~DigestStream()
{
    XXH3_freeState(static_cast<XXH3_state_t*>(state_));
}

void DigestStream::add(std::span<std::byte const> bytes)
{
    XXH3_128bits_update(static_cast<XXH3_state_t*>(state_), bytes.data(), bytes.size());
}

Digest DigestStream::digest() const
{
    auto const hash = XXH3_128bits_digest(static_cast<XXH3_state_t*>(state_));
    return {hash.high64, hash.low64};
}

std::string hex(std::uint64_t value)
{
    std::string text(16, '0');
    for (std::size_t i = 0; i < 16; ++i) text[15 - i] = "0123456789abcdef"[value >> (4 * i) & 0xf];
    return text;
}

std::string hex(Digest const& digest)
{
    return hex(digest.high) + hex(digest.low);
}

std::optional<std::uint64_t> from_hex(std::string_view text)
{
    bool const digits = text.find_first_not_of("0123456789abcdef") == std::string_view::npos;
    std::uint64_t value = 0;
    if (text.size() != 16 || !digits) return std::nullopt;
    std::from_chars(text.data(), text.data() + text.size(), value, 16);
    return value;
}

std::optional<Digest> digest_from_hex(std::string_view text)
{
    if (text.size() != 32) return std::nullopt;
    auto const high = from_hex(text.substr(0, 16)), low = from_hex(text.substr(16));
    if (!high || !low) return std::nullopt;
    return Digest{*high, *low};
}

}  // namespace sluice
