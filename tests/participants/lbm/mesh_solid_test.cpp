#include "participants/lbm/mesh_solid.hpp"

#include <doctest/doctest.h>

#include <filesystem>
#include <fstream>
#include <numbers>
#include <numeric>
#include <string>

#include "coupler/base/error.hpp"
#include "coupler/base/scratch_directory.hpp"
#include "coupler/scene/reader.hpp"
#include "participants/lbm/solids.hpp"
#include "participants/lbm/solver.hpp"
#include "tests/participants/lbm/surfaces.hpp"
#include "tests/support/close_to.hpp"
#include "tests/support/contains.hpp"

namespace {

using surfaces::Surface;

double sum_of(lbm::Patch<3> const& patch)
{
    return std::accumulate(patch.fraction.begin(), patch.fraction.end(), 0.0);
}

//! Share of a cell of the lattice; 0 outside the patch.
double share(lbm::Patch<3> const& p, lbm::Extent const& cell)
{
    lbm::Extent at;
    for (std::size_t k = 0; k < 3; ++k) {
        at[k] = cell[k] - p.first[k];
        if (at[k] < 0 || at[k] >= p.size[k]) return 0;
    }
    return p.fraction[static_cast<std::size_t>((at[2] * p.size[1] + at[1]) * p.size[0] + at[0])];
}

double largest_difference(lbm::Patch<3> const& a, lbm::Patch<3> const& b, lbm::Extent const& cells)
{
    double worst = 0;
    for (std::ptrdiff_t z = 0; z < cells[2]; ++z)
        for (std::ptrdiff_t y = 0; y < cells[1]; ++y)
            for (std::ptrdiff_t x = 0; x < cells[0]; ++x)
                worst = std::max(worst, std::abs(share(a, {x, y, z}) - share(b, {x, y, z})));
    return worst;
}

lbm::Patch<3> of_config(lbm::Solid const& solid)
{
    lbm::Config c;
    c.dimension = 3;
    c.cell = c.step = 1;
    c.size = {20, 18, 16};
    c.solids = {solid};
    return lbm::patches_of<3>(c).at(0);
}

std::string stl_text(Surface const& surface)
{
    std::string text = "solid s\n";
    for (auto const& t : surface) {
        text += "facet normal 0 0 0\nouter loop\n";
        for (auto const& p : t)
            text += "vertex " + std::to_string(p[0]) + " " + std::to_string(p[1]) + " " + std::to_string(p[2]) + "\n";
        text += "endloop\nendfacet\n";
    }
    return text + "endsolid s\n";
}

}  // namespace

TEST_CASE("mesh_solid: of a box along the axes every cell is exact, faces on cells' faces or not, whole or cut off")
{
    lbm::Extent const cells{20, 18, 16};
    for (auto const& [low, high] : {std::pair<files::Point, files::Point>{{3.3, 2.1, 4.7}, {9.6, 5.2, 12.05}},
                                    {{3, 4, 5}, {6, 9, 6}},
                                    {{3.2, 3.1, 3.4}, {3.7, 3.3, 3.6}},
                                    {{-2.5, 3, 4.5}, {7.5, 25, 22}}}) {
        lbm::Solid solid{.name = "box", .shape = lbm::Solid::Shape::box};
        for (std::size_t k = 0; k < 3; ++k) {
            solid.centre[k] = 0.5 * (low[k] + high[k]);
            solid.size[k] = high[k] - low[k];
        }
        auto const exact = of_config(solid);
        Surface const surface = surfaces::box(low, high);
        CHECK(lbm::open_edges(surface).empty());
        CHECK(largest_difference(lbm::mesh_patch(surface, cells), exact, cells) < 1e-12);
        CHECK(largest_difference(lbm::mesh_patch(surfaces::turned_inside_out(surface), cells), exact, cells) < 1e-12);
    }
}

TEST_CASE("mesh_solid: a sphere of many triangles has its volume to rounding and the cells of the analytic one")
{
    lbm::Extent const cells{20, 18, 16};
    double const radius = 5.3;
    Surface const surface = surfaces::sphere({9.7, 8.8, 7.6}, radius, 60);
    auto const patch = lbm::mesh_patch(surface, cells);
    CHECK(sum_of(patch) == close_to(4.0 / 3.0 * std::numbers::pi * std::pow(radius, 3)).epsilon(1e-12));
    auto const ball = of_config({.name = "ball", .centre = {9.7, 8.8, 7.6}, .radius = radius});
    // the analytic one's points are off by 0.012 (README); triangles by R (pi/60)^2/8 on a face of up to 1.5 cells
    CHECK(largest_difference(patch, ball, cells) < 0.015);
    CHECK(lbm::mean_curvature(surface) == close_to(1 / radius).epsilon(0.01));
    CHECK(patch.drag == close_to(ball.drag).epsilon(0.01));
}

TEST_CASE("mesh_solid: a hollow is open, two bodies are two, a cube's curvature is that of its edges")
{
    lbm::Extent const cells{20, 18, 16};
    Surface const cube = surfaces::box({4.5, 4.5, 4.5}, {12.5, 12.5, 12.5});
    Surface both = cube;
    Surface const hollow = surfaces::turned_inside_out(surfaces::box({6.25, 6, 6}, {9, 8.5, 8}));
    both.insert(both.end(), hollow.begin(), hollow.end());
    auto const patch = lbm::mesh_patch(both, cells);
    CHECK(sum_of(patch) == close_to(512 - 2.75 * 2.5 * 2));
    CHECK(share(patch, {7, 7, 7}) == 0);
    CHECK(share(patch, {6, 6, 6}) == close_to(0.25));
    CHECK(lbm::mean_curvature(cube) == close_to(std::numbers::pi / 2 / 8));  // 12 edges of 8, each turned by pi/2
    CHECK(lbm::mean_curvature(surfaces::turned_inside_out(cube)) == close_to(std::numbers::pi / 2 / 8));
}

TEST_CASE("mesh_solid: a surface with a hole or a facet the wrong way round is none of a solid")
{
    Surface open = surfaces::sphere({0, 0, 0}, 1, 8), wrong = open;
    open.pop_back();
    CHECK(contains(lbm::open_edges(open), "is not closed: 3 edges"));
    std::swap(wrong[7][0], wrong[7][1]);
    CHECK(contains(lbm::open_edges(wrong), "round opposite ways"));
}

TEST_CASE("mesh_solid: a scene's file, scaled, beside the scene, one that is not closed is refused")
{
    sluice::ScratchDirectory folder{"lbm_mesh"};
    Surface surface = surfaces::box({20, 30, 40}, {60, 50, 70});
    auto const read = [&](Surface const& s) {
        std::ofstream(folder.path() / "sill.stl") << stl_text(s);
        sluice::Reader reader = sluice::read_yaml(R"(
domain: {size: [0.2, 0.1, 0.1]}
cell: 1e-2
viscosity: 1e-3
max_velocity: 0.5
solids: [{name: sill, mesh: {file: sill.stl, scale: 1e-3}}]
)",
                                                  (folder.path() / "scene.yaml").string());
        return lbm::read_config(reader, 3, {0, 0, 0});
    };
    lbm::Config const c = read(surface);
    REQUIRE(c.solids.size() == 1);
    CHECK(c.solids[0].centre[0] == close_to(0.04));
    CHECK(c.solids[0].size[2] == close_to(0.03));
    lbm::Solver<3> solver(c);
    auto const fields = solver.fields();
    CHECK(std::accumulate(fields.solid_fraction.begin(), fields.solid_fraction.end(), 0.0) == close_to(4 * 2 * 3));
    auto const refused = [&](Surface const& s) {
        try {
            read(s);
        } catch (sluice::Error const& e) {
            return std::string(e.what());
        }
        return std::string();
    };
    surface.pop_back();
    CHECK(contains(refused(surface), "sill.stl is not closed"));
    CHECK(contains(refused(surfaces::box({400, 300, 400}, {600, 500, 700})), "lies outside the domain"));
}
