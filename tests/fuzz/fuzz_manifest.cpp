//! Manifest::parse: what it takes, text() gives back, and every member's file stays in its folder.
#include "coupler/base/error.hpp"
#include "coupler/record/manifest.hpp"
#include "tests/fuzz/target.hpp"

using namespace sluice;

extern "C" int LLVMFuzzerTestOneInput(std::uint8_t const* data, std::size_t size)
{
    std::string_view const text(reinterpret_cast<char const*>(data), size);
    try {
        auto const manifest = Manifest::parse(text, "input");
        auto const back = manifest.text();
        auto const covered = text.rfind(",\n \"xxh3\"");  // the checksum behind it is not looked at
        fuzz::demand(back.size() == size && back.compare(0, covered, text, 0, covered) == 0,
                     "one content has one text");
        for (auto const& part : manifest.members)
            fuzz::demand(part.member.find_first_of("/.") == std::string::npos, "a member is a name");
        ++fuzz::accepted;
    } catch (Error const& error) {
        fuzz::demand(error.exit() == Exit::io && std::string(error.what()).starts_with("input: "),
                     "an Error says where", error.what());
    }
    return 0;
}
