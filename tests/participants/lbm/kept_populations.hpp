#pragma once

#include <string>
#include <vector>

#include "participants/lbm/solver.hpp"

//! All populations of a solver, shape [q][z][y][x].
template <int D>
std::vector<double> populations_of(lbm::Solver<D>& solver)
{
    sluice::State kept;
    solver.keep(kept);
    std::vector<double> all;
    for (std::size_t q = 0; q < lbm::Lattice<D>::directions; ++q) {
        auto const cells = kept.numbers("populations/" + std::to_string(q));
        all.insert(all.end(), cells.begin(), cells.end());
    }
    return all;
}
