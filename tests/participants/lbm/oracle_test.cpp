#include <doctest/doctest.h>

#include <string>

#include "participants/lbm/solver.hpp"
#include "tests/participants/lbm/distance.hpp"
#include "tests/participants/lbm/kept_populations.hpp"
#include "tests/participants/lbm/plain_lattice.hpp"

namespace {

struct Scene
{
    char const* name;
    lbm::Operator collision;
    double smagorinsky, force;
    bool periodic_x, periodic_y, discs;
};

lbm::Config config(Scene const& s, lbm::Precision precision)
{
    lbm::Config c;
    c.precision = precision;
    c.cell = c.step = c.density = 1;
    c.size = {43, 29};
    c.viscosity = 0.02;
    c.collision = s.collision;
    c.smagorinsky = s.smagorinsky;
    c.acceleration = {s.force, -0.5 * s.force};
    c.set_periodic(0, s.periodic_x);
    c.set_periodic(1, s.periodic_y);
    if (!s.periodic_y) c.walls[lbm::top<2>].velocity[0] = 0.05;
    if (!s.periodic_x) c.walls[lbm::left].velocity[1] = -0.02;
    c.threads = 2;
    return c;
}

//! Four discs; two overlap, one crosses two sides of a periodic domain. None is driven into another or a wall: the
//! fluid that the lattice keeps between would be squeezed.
std::vector<lbm::Body<2>> discs_at(int step, bool periodic)
{
    double const t = step;
    lbm::Body<2> const last = periodic ? lbm::Body<2>{{42.2 + 0.02 * t, 28.0 + 0.02 * t}, 3.2, {0.02, 0.02}, {0.003}}
                                       : lbm::Body<2>{{37.2, 22.0 - 0.01 * t}, 3.2, {0, -0.01}, {0.003}};
    return {{10.3 + 0.03 * t, 12.1 - 0.01 * t, 4.7, 0.03, -0.01, 0.002},
            {19.0 + 0.03 * t, 12.4 - 0.02 * t, 4.4, 0.03, -0.02, -0.001},
            last,
            {30.0, 22.5, 2.5, 0, 0, 0}};
}

//! Largest differences after 300 steps.
Distance from_plain(Scene const& scene, lbm::Precision precision)
{
    lbm::Solver<2> fast(config(scene, precision));
    PlainLattice plain(config(scene, precision));
    fast.set_state([](std::array<double, 2> const& at) {
        auto const [x, y] = at;
        return lbm::PointState<2>{.velocity = {0.03 * std::sin(0.3 * y), 0.02 * std::cos(0.2 * x)},
                                  .pressure = 1e-3 * std::sin(0.1 * x * y),
                                  .gradient = {}};
    });
    auto const start = populations_of(fast);
    std::copy(start.begin(), start.end(), plain.populations().begin());
    double worst_load = 0;
    for (int step = 0; step < 300; ++step) {
        std::vector<lbm::Body<2>> const discs =
            scene.discs ? discs_at(step, scene.periodic_x && scene.periodic_y) : std::vector<lbm::Body<2>>{};
        std::vector<double> position, velocity, spin, radius;
        for (auto const& d : discs) {
            position.insert(position.end(), {d.centre[0], d.centre[1]});
            velocity.insert(velocity.end(), {d.velocity[0], d.velocity[1]});
            spin.push_back(d.spin[0]);
            radius.push_back(d.radius);
        }
        fast.set_bodies({position, velocity, spin, radius});
        fast.step();
        plain.step(discs);
        for (std::size_t i = 0; i < discs.size(); ++i) {
            auto const want = plain.loads()[i];
            worst_load = std::max({worst_load, std::abs(fast.exchange().force[2 * i] - want[0]),
                                   std::abs(fast.exchange().force[2 * i + 1] - want[1]),
                                   std::abs(fast.exchange().torque[i] - want[2])});
        }
    }
    return distance(populations_of(fast), plain.populations(), worst_load);
}

void check(Scene const& scene)
{
    INFO(std::string(scene.name));
    Distance const exact = from_plain(scene, lbm::Precision::float64);
    CHECK(exact.population < 1e-12);
    CHECK(exact.load < 1e-10);
    check_floats(from_plain(scene, lbm::Precision::float32), 300);
}

}  // namespace

TEST_CASE("solver: equals the plain lattice in every feature set, with and without moving discs")
{
    using enum lbm::Operator;
    check({"mrt, periodic", mrt, 0, 0, true, true, false});
    check({"bgk, channel", bgk, 0, 1e-5, true, false, false});
    check({"trt, box", trt, 0, 0, false, false, false});
    check({"mrt les, box", mrt, 0.15, 0, false, false, false});
    check({"mrt les force, box", mrt, 0.15, 1e-5, false, false, false});
    check({"mrt discs, periodic", mrt, 0, 0, true, true, true});
    check({"trt discs force, x walls", trt, 0, 1e-5, false, true, true});
    check({"mrt les discs, box", mrt, 0.15, 0, false, false, true});
    check({"mrt les discs force, channel", mrt, 0.15, 1e-5, true, false, true});
    check({"central force, channel", central, 0, 1e-5, true, false, false});
    check({"central discs, periodic", central, 0, 0, true, true, true});
    check({"central discs force, x walls", central, 0, 1e-5, false, true, true});
    check({"central les discs force, box", central, 0.15, 1e-5, false, false, true});
}
