#pragma once

#include <array>
#include <cstddef>

#include "participants/mpm/config.hpp"
#include "participants/mpm/state.hpp"

namespace unit {

//! An elastic block in a domain of `size` each way, in cells of 0.1 m.
template <int D>
mpm::Config box(double size, std::array<double, 3> low, std::array<double, 3> high)
{
    mpm::Config c;
    c.dimension = D;
    for (std::size_t k = 0; k < D; ++k) c.size[k] = size;
    c.cell = 0.1;
    c.density = 1000;
    c.law = mpm::LinearElastic{{1e5, 0.3}};
    c.bodies.push_back({.low = low, .high = high});
    return c;
}

template <int D>
mpm::Vec<D> momentum(mpm::State<D> const& state)
{
    mpm::Vec<D> sum = mpm::Vec<D>::Zero();
    for (auto const& p : state.points) sum += p.mass * p.velocity;
    return sum;
}

}  // namespace unit
