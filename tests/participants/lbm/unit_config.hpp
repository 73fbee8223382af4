#pragma once

#include <array>

#include "participants/lbm/config.hpp"

//! A lattice whose cell, step and density are 1.
template <int D>
lbm::Config unit_config(std::array<double, 3> const& size, double viscosity)
{
    lbm::Config c;
    c.dimension = D;
    c.cell = c.step = c.density = 1;
    c.size = size;
    c.viscosity = viscosity;
    return c;
}
