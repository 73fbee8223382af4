#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <numbers>
#include <string>

#include "coupler/base/scratch_directory.hpp"
#include "participants/dem/random.hpp"
#include "participants/dem/solver.hpp"
#include "tests/support/liggghts_column.hpp"
#include "tests/support/verification.hpp"

//! The real LIGGGHTS 3.8 as the oracle of space: a dense column in a box, hooke/stiffness with history and cdt rolling,
//! for 1000 steps from the same state. Positions, velocities and spins agree to 1e-9 of a diameter, of the largest
//! velocity and spin.
namespace {

using dem::Vec3;

constexpr double side = 0.06;
constexpr int across = 7, layers = 12, steps = 1000;

//! Spheres of 8 mm +- 10 % on a lattice that is closer than their diameters: pressed, moving and turning.
dem::Grains<3> dense_column()
{
    dem::Random random(11);
    dem::Grains<3> g;
    double const cell = side / across;
    for (int k = 0; k < across * across * layers; ++k) {
        auto const jitter = [&] { return random.uniform(-2e-4, 2e-4); };
        auto const about = [&](double scale) { return random.uniform(-scale, scale); };
        Vec3 const centre{(k % across + 0.5) * cell + jitter(), (k / across % across + 0.5) * cell + jitter(),
                          (k / across / across + 0.5) * 8.2e-3 + jitter()};
        dem::Motion<3> motion{};
        motion.velocity = {about(0.1), about(0.1), about(0.1)};
        motion.spin = {about(20.0), about(20.0), about(20.0)};
        g.add(centre, 4e-3 * random.uniform(0.9, 1.1), liggghts::density, motion);
    }
    return g;
}

void write_input(std::filesystem::path const& folder, dem::Grains<3> const& g)
{
    liggghts::write_data(folder / "column.data", g, side, "Atoms");
    std::ofstream(folder / "in.column")
        << liggghts::commands("column.data", side) << "dump d all custom " << steps
        << " out.dump id x y z vx vy vz omegax omegay omegaz\n"
           "dump_modify d sort id format \"%d %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g\"\nrun "
        << steps << '\n';
}

}  // namespace

TEST_CASE("LIGGGHTS: its order of things gives its trajectories, a dense column over 1000 steps")
{
    verification::Stopwatch watch;
    sluice::ScratchDirectory const folder("liggghts");
    dem::Grains<3> const start = dense_column();
    write_input(folder.path(), start);
    std::string const command = "cd " + folder.path().string() +
                                " && OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 "
                                "liggghts -in in.column > out.txt 2>&1";
    REQUIRE_MESSAGE(std::system(command.c_str()) == 0, "liggghts (Debian package) did not run");
    auto const theirs = liggghts::last_of_dump(folder.path() / "out.dump", start.size(), 9);
    REQUIRE(theirs.size() == start.size());

    dem::Solver<3> solver(liggghts::setup(side), start);
    for (int n = 0; n < steps; ++n) solver.step(liggghts::step);
    double place = 0.0, velocity = 0.0, spin = 0.0, fastest = 0.0, spinning = 0.0, path = 0.0;
    auto const& g = solver.grains();
    for (std::size_t i = 0; i < g.size(); ++i) {
        auto const vector = [&](std::size_t at) { return Vec3{theirs[i][at], theirs[i][at + 1], theirs[i][at + 2]}; };
        place = std::max(place, norm(g.place[i].centre - vector(0)));
        velocity = std::max(velocity, norm(g.motion[i].velocity - vector(3)));
        spin = std::max(spin, norm(g.motion[i].spin - vector(6)));
        fastest = std::max(fastest, norm(vector(3)));
        spinning = std::max(spinning, norm(vector(6)));
        path = std::max(path, norm(g.place[i].centre - start.place[i].centre));
    }
    CHECK(path > 1e-3);  // they have moved
    auto const check = [&](char const* what, double error) {
        CHECK(verification::report({"LIGGGHTS", what, error, 0.0, error, 1e-9, watch.seconds()}));
    };
    check("largest difference of places / d, 588 spheres", place / 8e-3);
    check("of velocities / largest", velocity / fastest);
    check("of spins / largest", spin / spinning);
}
