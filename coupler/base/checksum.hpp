#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace sluice {

//! XXH3-128 of some bytes. Finds accidents; it is no signature.
struct Digest
{
    std::uint64_t high = 0, low = 0;
    bool operator==(Digest const&) const = default;
};

Digest digest_of(std::span<std::byte const> bytes, std::uint64_t seed = 0);
//! XXH3-64.
std::uint64_t checksum_of(std::span<std::byte const> bytes, std::uint64_t seed = 0);

//! Of bytes that come in pieces; the same as digest_of() all of them.
class DigestStream
{
 public:
    explicit DigestStream(std::uint64_t seed = 0);
    DigestStream(DigestStream const&) = delete;
    DigestStream& operator=(DigestStream const&) = delete;
    ~DigestStream();
    void add(std::span<std::byte const> bytes);
    Digest digest() const;

 private:
    void* state_;
};

//! 32 or 16 lower-case hexadecimal digits, and back: nothing unless `text` is exactly that.
std::string hex(Digest const& digest);
std::string hex(std::uint64_t value);
std::optional<Digest> digest_from_hex(std::string_view text);
std::optional<std::uint64_t> from_hex(std::string_view text);

//! Is what was read what its checksum says? A fuzz build takes any checksum, or no mutation would get past it.
template <class Sum>
bool checksum_fits([[maybe_unused]] Sum const& stated, [[maybe_unused]] Sum const& found)
{
#ifdef FUZZING_BUILD_MODE_UNSAFE_FOR_PRODUCTION
    return true;
#else
    return stated == found;
#endif
}

}  // namespace sluice
