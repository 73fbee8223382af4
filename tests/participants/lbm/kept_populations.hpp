#pragma once

#include <cstring>
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
        auto const name = "populations/" + std::to_string(q);
        if (solver.config().precision == lbm::Precision::float64) {
            auto const cells = kept.numbers(name);
            all.insert(all.end(), cells.begin(), cells.end());
        } else {
            auto const bytes = kept.bytes(name);
            std::vector<float> cells(bytes.size() / sizeof(float));
            std::memcpy(cells.data(), bytes.data(), bytes.size());
            all.insert(all.end(), cells.begin(), cells.end());
        }
    }
    return all;
}
