#include "coupler/record/trace.hpp"

#include <doctest/doctest.h>

#include <nlohmann/json.hpp>

#include "coupler/base/error.hpp"
#include "coupler/record/atomic_file.hpp"
#include "tests/coupler/record/folder.hpp"

using namespace sluice;

namespace {

nlohmann::json events_of(std::filesystem::path const& path)
{
    return nlohmann::json::parse(read_file(path))["traceEvents"];
}

void fill(Trace& trace, std::uint64_t windows)
{
    for (std::uint64_t w = 0; w < windows; ++w) {
        auto const begin = 1e6 + static_cast<double>(w);
        trace.add(w, Activity::compute, begin, begin + 0.5);
        trace.add(w, Activity::wait, begin + 0.5, begin + 1);
    }
}

}  // namespace

TEST_CASE("trace: memory is bounded, totals count every window")
{
    test::Folder const folder;
    Trace trace("grains", 100);
    fill(trace, 1000);
    CHECK(trace.stride() == 16);
    CHECK(trace.seconds(Activity::compute) == 500);
    CHECK(trace.seconds(Activity::exchange) == 0);
    trace.write(folder / "t.json");
    auto const events = events_of(folder / "t.json");
    CHECK(events.size() == 1 + 2 * 63);
    CHECK(events[1]["args"]["window"] == 0);
    CHECK(events[3]["args"]["window"] == 16);
}

TEST_CASE("trace: merging gives each participant a process and starts at zero")
{
    test::Folder const folder;
    Trace grains("grains"), water("wa\"ter");
    fill(grains, 2);
    fill(water, 3);
    grains.write(folder / "g.json");
    water.write(folder / "w.json");
    std::filesystem::path const parts[] = {folder / "g.json", folder / "w.json"};
    merge_traces(parts, folder / "trace.json");
    auto const events = events_of(folder / "trace.json");
    REQUIRE(events.size() == 2 + 4 + 6);
    CHECK(events[0]["args"]["name"] == "grains");
    CHECK(events[5]["args"]["name"] == "wa\"ter");
    CHECK(events[1]["ts"] == 0.0);
    CHECK(events[1]["dur"] == 5e5);
    CHECK(events[6]["pid"] == 2);
}

TEST_CASE("trace: a cut-off or foreign file is an error")
{
    test::Folder const folder;
    std::filesystem::path const parts[] = {folder / "g.json"};
    for (char const* text : {"{\"traceEvents\":[", "[]", "{\"traceEvents\":[{}]}"}) {
        write_atomically(parts[0], text);
        CHECK_THROWS_AS(merge_traces(parts, folder / "t.json"), Error);
    }
}
