#include "coupler/record/image_series.hpp"

#include <doctest/doctest.h>

#include <vector>

#include "coupler/record/atomic_file.hpp"
#include "tests/coupler/record/folder.hpp"

using namespace sluice;

TEST_CASE("image_series: a 2D lattice is a plane of cells with its origin and spacing")
{
    test::Folder const folder;
    ImageSeries series(folder.path(), "water", {{-1, 0.5, 0}, {0.1, 0.2, 1}, {3, 2, 0}});
    std::vector<float> const pressure{1, 2, 3, 4, 5, 6};
    CellColumn const columns[] = {{"pressure", "Pa", 1, pressure}};
    series.append(0.25, columns);
    std::string const file = read_file(folder / "water/water_000000.vti");
    CHECK(file.find("WholeExtent=\"0 3 0 2 0 0\" Origin=\"-1 0.5 0\" Spacing=\"0.1 0.2 1\"") != std::string::npos);
    std::string const bytes(reinterpret_cast<char const*>(pressure.data()), pressure.size() * sizeof(float));
    CHECK(file.find(bytes) != std::string::npos);
    CHECK(read_collection(series.collection()).at(0).time == 0.25);
}

TEST_CASE("image_series: a 3D lattice counts its cells")
{
    Lattice const lattice{{}, {1, 1, 1}, {3, 2, 4}};
    CHECK(lattice.cell_count() == 24);
    test::Folder const folder;
    ImageSeries series(folder.path(), "water", lattice);
    std::vector<float> const velocity(72, 1.5F);
    CellColumn const columns[] = {{"velocity", "m/s", 3, velocity}};
    series.append(0, columns);
    CHECK(read_file(folder / "water/water_000000.vti").find("Extent=\"0 3 0 2 0 4\"") != std::string::npos);
}
