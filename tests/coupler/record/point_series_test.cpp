#include "coupler/record/point_series.hpp"

#include <doctest/doctest.h>

#include <cstring>
#include <vector>

#include "coupler/base/error.hpp"
#include "coupler/record/atomic_file.hpp"
#include "tests/coupler/record/folder.hpp"

using namespace sluice;

namespace {

struct Points
{
    std::vector<std::int64_t> id;
    std::vector<double> position;
    std::vector<PointColumn> columns() const { return {{"position", "m", 2, position}}; }
};

//! The values of the array whose <DataArray> line holds `name`.
template <class Value>
std::vector<Value> appended(std::string const& file, std::string const& name)
{
    std::size_t const line = file.find("Name=\"" + name + "\"");
    std::size_t const offset = std::stoul(file.substr(file.find("offset=\"", line) + 8));
    std::size_t const start = file.find("<AppendedData encoding=\"raw\">\n_") + 31 + offset;
    std::uint64_t bytes = 0;
    std::memcpy(&bytes, file.data() + start, sizeof bytes);
    std::vector<Value> values(bytes / sizeof(Value));
    if (bytes > 0) std::memcpy(values.data(), file.data() + start + sizeof bytes, bytes);
    return values;
}

}  // namespace

TEST_CASE("point_series: 2D positions are padded with z = 0")
{
    test::Folder const folder;
    PointSeries series(folder.path(), "grains");
    Points const points{{7, 9}, {1, 2, 3, 4}};
    series.append(0.5, points.id, points.columns());
    std::string const file = read_file(folder / "grains/grains_000000.vtp");
    CHECK(appended<double>(file, "position") == std::vector<double>{1, 2, 0, 3, 4, 0});
    CHECK(appended<std::int64_t>(file, "id") == std::vector<std::int64_t>{7, 9});
    CHECK(appended<std::int64_t>(file, "connectivity") == std::vector<std::int64_t>{0, 1});
    CHECK(appended<std::int64_t>(file, "offsets") == std::vector<std::int64_t>{1, 2});
}

TEST_CASE("point_series: lines go from each even point to the next")
{
    test::Folder const folder;
    PointSeries series(folder.path(), "forces", Precision::float64, std::nullopt, PointSeries::Cells::lines);
    Points const points{{7, 9, 9, -1}, {1, 2, 3, 4, 3, 4, 3, 0}};
    series.append(0.5, points.id, points.columns());
    std::string const file = read_file(folder / "forces/forces_000000.vtp");
    CHECK(file.find("NumberOfPoints=\"4\" NumberOfVerts=\"0\" NumberOfLines=\"2\"") != std::string::npos);
    CHECK(file.find("<Lines>") != std::string::npos);
    CHECK(appended<std::int64_t>(file, "connectivity") == std::vector<std::int64_t>{0, 1, 2, 3});
    CHECK(appended<std::int64_t>(file, "offsets") == std::vector<std::int64_t>{2, 4});
}

TEST_CASE("point_series: single precision halves the numbers")
{
    test::Folder const folder;
    PointSeries series(folder.path(), "grains", Precision::float32);
    Points const points{{1}, {0.1, 0.2}};
    series.append(0, points.id, points.columns());
    std::string const file = read_file(folder / "grains/grains_000000.vtp");
    CHECK(appended<float>(file, "position") == std::vector<float>{0.1F, 0.2F, 0});
}

TEST_CASE("point_series: the collection lists every frame as it comes, also an empty one")
{
    test::Folder const folder;
    PointSeries series(folder.path(), "grains");
    CHECK(read_collection(series.collection()).empty());
    series.append(0, {}, Points{}.columns());
    Points const points{{1}, {0, 0}};
    series.append(1.0 / 3.0, points.id, points.columns());
    auto const entries = read_collection(series.collection());
    REQUIRE(entries.size() == 2);
    CHECK(entries[1].time == 1.0 / 3.0);
    CHECK(entries[1].file == "grains/grains_000001.vtp");
    CHECK(read_file(folder / "grains/grains_000000.vtp").find("NumberOfPoints=\"0\"") != std::string::npos);
}

TEST_CASE("point_series: a frame without positions is an error that names the series")
{
    test::Folder const folder;
    PointSeries series(folder.path(), "grains");
    CHECK_THROWS_WITH_AS(series.append(0, {}, {}),
                         "grains: the frame has no column \"position\" with 2 or 3 components (needed to place the "
                         "points). Add it in the participant that writes this series.",
                         Error);
}

TEST_CASE("collection: merging numbers the parts, sorts by time and makes names relative")
{
    test::Folder const folder;
    CollectionEntry const grains[] = {{0, 0, "grains/a.vtp"}, {0.2, 0, "grains/b & c.vtp"}};
    CollectionEntry const water[] = {{0, 0, "water/a.vti"}, {0.1, 0, "water/b.vti"}};
    write_collection(folder / "sub/grains.pvd", grains);
    write_collection(folder / "water.pvd", water);
    std::filesystem::path const parts[] = {folder / "sub/grains.pvd", folder / "water.pvd"};
    merge_collections(parts, folder / "all.pvd");
    auto const all = read_collection(folder / "all.pvd");
    REQUIRE(all.size() == 4);
    CHECK(all[0].file == "sub/grains/a.vtp");
    CHECK(all[1].part == 1);
    CHECK(all[2].file == "water/b.vti");
    CHECK(all[3].file == "sub/grains/b & c.vtp");
    CHECK(all[3].time == 0.2);
}
