#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "tests/verification/lbm/free_body.hpp"
#include "tests/verification/lbm/lattice_case.hpp"

//! Spheres that start from rest. A quarter of the box, mirrored at two sides without friction.
using namespace lattice_case;

namespace {

constexpr double earth = 9.81;  // m/s2

lbm::Config quarter(double width, double height, double cell)
{
    lbm::Config c;
    c.dimension = 3;
    c.cell = cell;
    c.size = {0.5 * width, 0.5 * width, height};
    c.collision = lbm::Operator::trt;
    c.walls[lbm::left].kind = c.walls[lbm::lower_y].kind = lbm::Border::slip;
    return c;
}

//! A sphere of 15 mm and 1120 kg/m3 in a box of oil, 100 x 100 x 160 mm: ten Cate, Nieuwstad, Derksen and Van den
//! Akker, Phys. Fluids 14 (2002) 4012, table I; the fastest of table II, times read off their figure 5a.
struct Oil
{
    char const* name;
    double density, viscosity;  //!< kg/m3, Pa s
    double fastest;             //!< measured [m/s]
    double fall;                //!< measured, from h/d = 4 to 1, h the gap below [s]
    double mark;                //!< of the fastest
};

struct Settled
{
    double fastest, fall, last;  //!< last: velocity at h/d = 0.1 over the fastest [-]
};

Settled settle(Oil const& oil, double cells)
{
    constexpr double diameter = 0.015;
    lbm::Config c = quarter(0.1, 0.16, diameter / cells);
    c.density = oil.density;
    c.viscosity = oil.viscosity / oil.density;
    c.step = 0.05 * c.cell / oil.fastest;
    lbm::Solver<3> solver(c);
    FreeBody<3> sphere({0, 0, 0.1275}, 0.5 * diameter, 1120, oil.density);
    sphere.images = 4;
    double const weight = (sphere.mass - sphere.displaced) * earth;
    auto const gap = [&] { return sphere.position[2] / diameter - 0.5; };
    Settled got{};
    double four = 0, one = 0;
    while (gap() > 0.1) {
        sphere.step(solver, {0, 0, -weight});
        got.fastest = std::max(got.fastest, -sphere.up());
        if (gap() > 4) four = solver.time();
        if (gap() > 1) one = solver.time();
    }
    got.fall = one - four;
    got.last = -sphere.up() / got.fastest;
    return got;
}

void check_settling(Oil const& oil, double cells)
{
    verification::Stopwatch const watch;
    Settled const got = settle(oil, cells);
    std::string const name = oil.name + text(", d = %.0f dx: ", cells, 0);
    CHECK(verification::report({"C02", name + "fastest [m/s]", got.fastest, oil.fastest,
                                relative(got.fastest, oil.fastest), oil.mark, watch.seconds()}));
    // mark: what curves can be read to, 4 %
    CHECK(verification::report({"C02", name + "fall from h/d = 4 to 1 [s]", got.fall, oil.fall,
                                relative(got.fall, oil.fall), 0.04, watch.seconds()}));
    CHECK(got.last < 0.9);  // it slows down above the floor
}

// marks: the file's for 15 cells a diameter; of E1, which every published simulation has too slow by 3 to 5 %, 8 %
constexpr Oil e1{"E1", 970, 0.373, 0.03599, 1.358, 0.08}, e3{"E3", 962, 0.113, 0.08727, 0.536, 0.04},
    e4{"E4", 960, 0.058, 0.12224, 0.376, 0.04};

}  // namespace

TEST_CASE("C02: a sphere settles in a box, ten Cate's E1, E3 and E4, d = 6 cells")
{
    for (Oil const& oil : {e1, e3, e4}) check_settling(oil, 6);
}

TEST_CASE("C02: the same, d = 9 cells, and E4 with 12")
{
    for (Oil const& oil : {e1, e3, e4}) check_settling(oil, 9);
    check_settling(e4, 12);
}
