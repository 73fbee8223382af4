//! A scene's text: every refusal says line and column, and they are in the text.
#include <algorithm>

#include "coupler/base/error.hpp"
#include "coupler/scene/scene.hpp"
#include "tests/fuzz/target.hpp"

using namespace sluice;

namespace {

void demand_place(std::string const& message, std::string const& file, long lines)
{
    int line = 0, column = 0;
    bool const placed =
        message.starts_with(file + ":") && std::sscanf(message.c_str() + file.size(), ":%d:%d: ", &line, &column) == 2;
    fuzz::demand(placed && line >= 1 && line <= lines && column >= 1, "every refusal has its line and column", message);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(std::uint8_t const* data, std::size_t size)
{
    fuzz::MemoryFile const file({data, size});
    long const lines = 2 + std::count_if(data, data + size, [](auto c) { return c == '\n' || c == '\r'; });
    try {
        auto const scene = load_scene(file.path(), {});
        for (auto const& text : scene.diagnostics->sorted()) demand_place(text, file.path(), lines);
        fuzz::accepted += scene.diagnostics->problems.empty();
    } catch (Error const& error) {
        fuzz::demand(error.exit() == Exit::config, "a scene's mistake is one of exit code 2", error.what());
        demand_place(error.what(), file.path(), lines);
    }
    return 0;
}
