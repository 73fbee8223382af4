//! State::decode: what it takes, encode() gives back byte for byte.
#include <algorithm>
#include <cstring>
#include <vector>

#include "coupler/base/error.hpp"
#include "coupler/base/state.hpp"
#include "tests/fuzz/target.hpp"

using namespace sluice;

extern "C" int LLVMFuzzerTestOneInput(std::uint8_t const* data, std::size_t size)
{
    auto const given = std::as_bytes(std::span(data, size));
    std::vector<std::byte> bytes(given.begin(), given.end());
    std::uint64_t const length = size;  // the length it states, at byte 24, is made right
    if (size >= 64) std::memcpy(bytes.data() + 24, &length, sizeof length);
    try {
        auto const encoded = State::decode(bytes, "input").encode();
        auto const same = [&](std::size_t from, std::size_t to) {  // the checksum between them is not looked at
            return std::equal(encoded.begin() + static_cast<std::ptrdiff_t>(from),
                              encoded.begin() + static_cast<std::ptrdiff_t>(to),
                              bytes.begin() + static_cast<std::ptrdiff_t>(from));
        };
        fuzz::demand(encoded.size() == size && same(0, 32) && same(48, size), "one content has one encoding");
        ++fuzz::accepted;
    } catch (Error const& error) {
        fuzz::demand(error.exit() == Exit::io && std::string(error.what()).starts_with("input: "),
                     "an Error says where", error.what());
    }
    return 0;
}
