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
#include "tests/support/verification.hpp"
#include "tests/verification/dem/scenes.hpp"

//! The real LIGGGHTS 3.8 as the oracle of space: a dense column in a box, hooke/stiffness with history and cdt rolling,
//! for 1000 steps from the same state. Positions, velocities and spins agree to 1e-9 of a diameter, of the largest
//! velocity and spin. contact_distance_factor above 1: else LIGGGHTS keeps the history of contacts that have opened.
namespace {

using dem::Vec3;

constexpr double kn = 1e5, kt = 2e5 / 7.0, gamma_n = 0.953, gamma_t = 0.477, mu = 0.5, mu_r = 0.079;
constexpr double time_step = 5e-6, side = 0.06, density = 2650.0;
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
        g.add(centre, 4e-3 * random.uniform(0.9, 1.1), density, motion);
    }
    return g;
}

dem::Solver<3> ours(dem::Grains<3> const& grains)
{
    dem::Setup<3> s;
    s.gravity = {0.0, 0.0, -9.81};
    s.law.normal = {.stiffness = kn, .damping = gamma_n, .floor = -std::numeric_limits<double>::infinity()};
    s.law.tangential = {.stiffness = kt, .damping = gamma_t, .friction = mu};
    s.law.rolling = {.friction = mu_r};
    s.skin = 1e-3;
    s.absolute_damping = true;
    s.features = {.friction = true, .rolling = dem::Rolling::constant, .scheme = dem::Scheme::liggghts};
    scenes::add_wall<3>(s, {}, {0, 0, 1});
    scenes::add_wall<3>(s, {}, {1, 0, 0});
    scenes::add_wall<3>(s, {}, {0, 1, 0});
    scenes::add_wall<3>(s, {side, 0, 0}, {-1, 0, 0});
    scenes::add_wall<3>(s, {0, side, 0}, {0, -1, 0});
    return {s, grains};
}

void write_input(std::filesystem::path const& folder, dem::Grains<3> const& g)
{
    std::ofstream data(folder / "column.data");
    data.precision(17);
    data << "column\n\n"
         << g.size() << " atoms\n1 atom types\n\n0 " << side << " xlo xhi\n0 " << side
         << " ylo yhi\n0 0.2 zlo zhi\n\nAtoms\n\n";
    for (std::size_t i = 0; i < g.size(); ++i) {
        auto const& c = g.place[i].centre;
        data << i + 1 << " 1 " << 2.0 * g.place[i].radius << ' ' << density << ' ' << c.x << ' ' << c.y << ' ' << c.z
             << '\n';
    }
    data << "\nVelocities\n\n";
    for (std::size_t i = 0; i < g.size(); ++i) {
        auto const &v = g.motion[i].velocity, &w = g.motion[i].spin;
        data << i + 1 << ' ' << v.x << ' ' << v.y << ' ' << v.z << ' ' << w.x << ' ' << w.y << ' ' << w.z << '\n';
    }
    std::ofstream in(folder / "in.column");
    in.precision(17);
    std::string const model = "model hooke/stiffness tangential history rolling_friction cdt ",
                      damped =
                          "absolute_damping on "
                          "tangential_damping on\n";
    in << "units si\natom_style granular\natom_modify map array\nboundary f f f\nnewton off\n"
          "communicate single vel yes\nread_data column.data\nneighbor 0.001 bin\n"
          "neigh_modify delay 0 every 1 check yes contact_distance_factor 1.05\n"
       << "fix m1 all property/global kn peratomtypepair 1 " << kn
       << "\nfix m2 all property/global kt peratomtypepair 1 " << kt
       << "\nfix m3 all property/global gamman_abs peratomtypepair 1 " << gamma_n
       << "\nfix m4 all property/global gammat_abs peratomtypepair 1 " << gamma_t
       << "\nfix m5 all property/global coefficientFriction peratomtypepair 1 " << mu
       << "\nfix m6 all property/global coefficientRollingFriction peratomtypepair 1 " << mu_r << "\npair_style gran "
       << model << damped << "pair_coeff * *\nfix grav all gravity 9.81 vector 0.0 0.0 -1.0\n";
    struct Side
    {
        char const* plane;
        double at;
    };
    int n = 0;
    for (auto const& [plane, at] :
         {Side{"xplane", 0.0}, Side{"xplane", side}, Side{"yplane", 0.0}, Side{"yplane", side}, Side{"zplane", 0.0}})
        in << "fix w" << n++ << " all wall/gran " << model << "primitive type 1 " << plane << ' ' << at << ' '
           << damped;
    in << "fix integr all nve/sphere\ntimestep " << time_step << "\ndump d all custom " << steps
       << " out.dump id x y z vx vy vz omegax omegay omegaz\n"
          "dump_modify d sort id format \"%d %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g\"\nrun "
       << steps << "\n";
}

struct Row
{
    Vec3 centre, velocity, spin;
};

//! The last frame of the dump, by id.
std::vector<Row> read_dump(std::filesystem::path const& file, std::size_t grains)
{
    std::ifstream in(file);
    std::vector<Row> rows;
    for (std::string line; std::getline(in, line);) {
        if (line.rfind("ITEM: ATOMS", 0) != 0) continue;
        rows.clear();
        for (std::size_t i = 0; i < grains; ++i) {
            Row r;
            long id = 0;
            in >> id >> r.centre.x >> r.centre.y >> r.centre.z >> r.velocity.x >> r.velocity.y >> r.velocity.z >>
                r.spin.x >> r.spin.y >> r.spin.z;
            if (static_cast<std::size_t>(id) == i + 1) rows.push_back(r);
        }
    }
    return rows;
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
    auto const theirs = read_dump(folder.path() / "out.dump", start.size());
    REQUIRE(theirs.size() == start.size());

    dem::Solver<3> solver = ours(start);
    for (int n = 0; n < steps; ++n) solver.step(time_step);
    double place = 0.0, velocity = 0.0, spin = 0.0, fastest = 0.0, spinning = 0.0, path = 0.0;
    auto const& g = solver.grains();
    for (std::size_t i = 0; i < g.size(); ++i) {
        place = std::max(place, norm(g.place[i].centre - theirs[i].centre));
        velocity = std::max(velocity, norm(g.motion[i].velocity - theirs[i].velocity));
        spin = std::max(spin, norm(g.motion[i].spin - theirs[i].spin));
        fastest = std::max(fastest, norm(theirs[i].velocity));
        spinning = std::max(spinning, norm(theirs[i].spin));
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
