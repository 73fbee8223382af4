#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "coupler/base/error.hpp"
#include "coupler/mapping/mapping.hpp"

namespace sluice {

template <int D>
using Place = Eigen::Matrix<double, D, 1>;
template <int D>
using Places = std::vector<Place<D>>;

//! Checked and copied. Throws Error if a position is not finite or a number is left over.
template <int D>
Places<D> places(std::span<double const> position, std::string const& who)
{
    require(position.size() % D == 0, [&] {
        return Error("mapping " + who + ": " + std::to_string(position.size()) +
                     " numbers (needed: " + std::to_string(D) + " a point).");
    });
    Places<D> result(position.size() / D);
    for (std::size_t i = 0; i < result.size(); ++i) {
        for (int k = 0; k < D; ++k) result[i][k] = position[i * D + static_cast<std::size_t>(k)];
        require(result[i].cwiseAbs().maxCoeff() < 1e100 && result[i].allFinite(), [&] {
            return Error("mapping " + who + ": a position of point " + std::to_string(i) +
                             " is not finite (needed: below 1e100 m).",
                         Exit::numerical);
        });
    }
    return result;
}

//! Checks both sets, then calls build(source places, target places) for their dimension.
template <class Build>
Mapping build_mapping(std::string const& name, Points sources, Points targets, Build&& build)
{
    int const d = sources.dimension;
    require(d == targets.dimension && (d == 2 || d == 3), [&] {
        return Error("mapping " + name + ": dimensions " + std::to_string(d) + " and " +
                     std::to_string(targets.dimension) + " (needed: both 2 or both 3).");
    });
    require(!sources.position.empty() || targets.position.empty(), [&] {
        return Error("mapping " + name + ": no sources for " +
                     std::to_string(targets.position.size() / static_cast<std::size_t>(d)) + " targets (at least 1).");
    });
    if (d == 2) return build(places<2>(sources.position, name), places<2>(targets.position, name));
    return build(places<3>(sources.position, name), places<3>(targets.position, name));
}

}  // namespace sluice
