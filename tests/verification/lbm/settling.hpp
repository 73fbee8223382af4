#pragma once

#include <algorithm>

#include "tests/verification/lbm/free_body.hpp"
#include "tests/verification/lbm/lattice_case.hpp"

namespace lattice_case {

inline constexpr double earth = 9.81;  // m/s2

inline lbm::Config upright_box(double width, double height, double cell)
{
    lbm::Config c;
    c.dimension = 3;
    c.cell = cell;
    c.size = {width, width, height};
    c.collision = lbm::Operator::trt;
    return c;
}

//! A quarter of it, mirrored at two sides without friction.
inline lbm::Config quarter(double width, double height, double cell)
{
    lbm::Config c = upright_box(0.5 * width, height, cell);
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
};

inline constexpr double sphere_diameter = 0.015, box_width = 0.1, box_height = 0.16;  // m

//! What the lattice holds of the box: a quarter; all of it with an interpolated surface, which knows no mirrors.
struct PartOfBox
{
    bool whole;

    explicit PartOfBox(lbm::Surface surface) : whole(surface == lbm::Surface::interpolated) {}
    lbm::Config config(double cells) const
    {
        return (whole ? upright_box : quarter)(box_width, box_height, sphere_diameter / cells);
    }
    double axis() const { return whole ? 0.5 * box_width : 0; }  //!< of the box [m]
    double images() const { return whole ? 1 : 4; }
};

struct Settled
{
    double fastest, fall, last;  //!< last: velocity at h/d = 0.1 over the fastest [-]
};

inline Settled settle(Oil const& oil, double cells, Variant const& variant = {.collision = lbm::Operator::trt})
{
    PartOfBox const part(variant.surface);
    lbm::Config c = part.config(cells);
    variant.set(c);
    c.density = oil.density;
    c.viscosity = oil.viscosity / oil.density;
    c.step = 0.05 * c.cell / oil.fastest;
    lbm::Solver<3> solver(c);
    FreeBody<3> sphere({part.axis(), part.axis(), 0.1275}, 0.5 * sphere_diameter, 1120, oil.density);
    sphere.images = part.images();
    double const weight = (sphere.mass - sphere.displaced) * earth;
    auto const gap = [&] { return sphere.position[2] / sphere_diameter - 0.5; };
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

inline constexpr Oil e1{"E1", 970, 0.373, 0.03599, 1.358}, e3{"E3", 962, 0.113, 0.08727, 0.536},
    e4{"E4", 960, 0.058, 0.12224, 0.376};

}  // namespace lattice_case
