#include <doctest/doctest.h>

#include <cmath>
#include <cstdio>
#include <numbers>
#include <vector>

#include "participants/dem/lubrication.hpp"
#include "participants/lbm/solver.hpp"
#include "tests/support/verification.hpp"
#include "tests/verification/lbm/lattice_case.hpp"

//! The drag of a sphere that comes to a wall: what the lattice has of it and what the grains' film adds below 2/3 of a
//! cell. Lattice units.
namespace {

constexpr double radius = 6, viscosity = 1.0 / 3;

//! F/(6 pi mu a U) of a sphere whose gap to a wall is h, creeping. Brenner, Chem. Eng. Sci. 16 (1961) 242, eq. 2.19.
double creeping_drag(double h)
{
    double const alpha = std::acosh(1 + h / radius), s1 = std::sinh(alpha);
    double sum = 0;
    for (int n = 1; n < 2000; ++n) {
        double const m = 2 * n + 1, grown = 0.5 * m * alpha;
        if (grown > 300) break;  // the bracket has gone to 0
        double const bracket = (2 * std::sinh(m * alpha) + m * std::sinh(2 * alpha)) /
                                   (4 * std::sinh(grown) * std::sinh(grown) - m * m * s1 * s1) -
                               1;
        sum += n * (n + 1.0) / ((2 * n - 1.0) * (2 * n + 3.0)) * bracket;
    }
    return 4.0 / 3 * s1 * sum;
}

//! The same by the lattice alone: at rest at this gap, its surface moving down. A quarter, 12 radii wide, 10 high.
double lattice_drag(double h)
{
    lbm::Config c;
    c.dimension = 3;
    c.cell = c.step = c.density = 1;
    c.size = {6 * radius, 6 * radius, 10 * radius};
    c.viscosity = viscosity;
    c.collision = lbm::Operator::trt;
    for (std::size_t const side : {0UL, 1UL, 2UL, 3UL}) c.walls[side].kind = lbm::Border::slip;
    c.walls[lbm::top<3>].kind = lbm::Border::slip;
    lbm::Solver<3> solver(c);
    double const speed = 1e-4;  // Re = 0.004
    std::vector<double> const place{0, 0, radius + h}, velocity{0, 0, -speed}, spin(3), size{radius};
    solver.set_bodies({place, velocity, spin, size});
    double const force =
        lattice_case::run_to_steady(solver, 100, 1e-3, 4000, [&] { return 4 * solver.exchange().force[2]; });
    return force / (6 * std::numbers::pi * viscosity * radius * speed);
}

}  // namespace

TEST_CASE("C12: drag of a sphere near a wall, the lattice's and the film's, a = 6 cells")
{
    dem::Lubrication const film{.viscosity = viscosity, .cutoff = 2.0 / 3, .floor = 1e-3};
    double const unit = 6 * std::numbers::pi * viscosity * radius;
    for (double const h : {2.0, 1.0, 0.6, 0.3, 0.1, 0.03}) {
        verification::Stopwatch const watch;
        double const lattice = lattice_drag(h), total = lattice + film.resistance<3>(h, radius) / unit,
                     exact = creeping_drag(h);
        std::printf("C12   gap %.2f dx: exact %.3f, lattice %.3f (%+.1f %%), with film %.3f (%+.1f %%), %.1f s\n", h,
                    exact, lattice, 100 * (lattice / exact - 1), total, 100 * (total / exact - 1), watch.seconds());
        // mark: 20 %, that of waLBerla's tests of lubrication
        CHECK(verification::report({"C12", lattice_case::text("F/(6 pi mu a U), gap %.2f dx, a = %.0f dx", h, radius),
                                    total, exact, std::abs(total / exact - 1), 0.2, watch.seconds()}));
    }
}
