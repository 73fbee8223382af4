#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "coupler/mapping/lattice_mapping.hpp"

namespace sluice {

constexpr int support(LatticeKernel kernel)
{
    return kernel == LatticeKernel::hat ? 2 : kernel == LatticeKernel::three_point ? 3 : 4;
}

template <LatticeKernel K>
using AxisWeights = std::array<double, static_cast<std::size_t>(support(K))>;

//! One axis, s in spacings from the lattice's lower corner: fills the weights, returns the first of their cells.
//! f is the distance to the cell's centre below (hat, four_point) or nearest (three_point).
template <LatticeKernel K>
std::int64_t axis_weights(double s, AxisWeights<K>& w) noexcept
{
    if constexpr (K == LatticeKernel::hat) {
        double const below = std::floor(s - 0.5), f = s - 0.5 - below;
        w = {1 - f, f};
        return static_cast<std::int64_t>(below);
    } else if constexpr (K == LatticeKernel::three_point) {
        double const nearest = std::floor(s), f = s - 0.5 - nearest;
        double const q = std::sqrt(1 - 3 * f * f);
        w = {(2 - 3 * f - q) / 6, (1 + q) / 3, (2 + 3 * f - q) / 6};
        return static_cast<std::int64_t>(nearest) - 1;
    } else {
        double const below = std::floor(s - 0.5), f = s - 0.5 - below;
        double const q = std::sqrt(1 + 4 * f * (1 - f));
        w = {(3 - 2 * f - q) / 8, (3 - 2 * f + q) / 8, (1 + 2 * f + q) / 8, (1 + 2 * f - q) / 8};
        return static_cast<std::int64_t>(below) - 1;
    }
}

//! Moves weights of cells below 0 and from n on to cells inside; first becomes the first cell of a block inside.
//! Needs n >= the number of weights.
template <std::size_t S>
void fold(std::array<double, S>& w, std::int64_t& first, std::int64_t n, Border border) noexcept
{
    std::int64_t const start = std::min(std::max<std::int64_t>(first, 0), n - static_cast<std::int64_t>(S));
    std::array<double, S> inside = {};
    auto const add = [&](std::int64_t cell, double weight) {
        inside[static_cast<std::size_t>(cell - start)] += weight;
    };
    for (std::size_t k = 0; k < S; ++k) {
        std::int64_t const cell = first + static_cast<std::int64_t>(k);
        std::int64_t const beyond = cell < 0 ? -cell : cell >= n ? cell - n + 1 : 0;  // 1: the first cell outside
        std::int64_t const wall = cell < 0 ? 0 : n - 1, step = cell < 0 ? 1 : -1;
        if (beyond == 0) {
            add(cell, w[k]);
        } else if (border == Border::mirror) {
            add(wall + step * (beyond - 1), w[k]);
        } else {  // value there = (1 + beyond) value at the wall - beyond * that of the next cell
            add(wall, static_cast<double>(1 + beyond) * w[k]);
            add(wall + step, -static_cast<double>(beyond) * w[k]);
        }
    }
    w = inside;
    first = start;
}

}  // namespace sluice
