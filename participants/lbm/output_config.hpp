#pragma once

#include <array>
#include <string>
#include <vector>

#include "coupler/scene/reader.hpp"

namespace lbm {

//! What a picture holds.
struct FieldChoice
{
    bool velocity = true, pressure = true, vorticity = true, solid_fraction = true;
    bool q_criterion = false;
    bool operator==(FieldChoice const&) const = default;
};

//! Where the time series says what the fluid does. [m]
struct Probe
{
    std::string name;
    std::array<double, 3> place{};
};

//! Places from one end to the other, evenly spread, each in a row of a table of its own.
struct Line
{
    std::string name;
    std::array<double, 3> from{}, to{};
    int points = 2;

    std::array<double, 3> place(int k) const
    {
        std::array<double, 3> at = from;
        for (std::size_t axis = 0; axis < 3; ++axis) at[axis] += (to[axis] - from[axis]) * k / (points - 1);
        return at;
    }
};

//! What a run leaves behind beyond what is always there.
struct OutputConfig
{
    FieldChoice fields;
    bool energy = false;  //!< kinetic energy and enstrophy in the time series
    std::vector<Probe> probes{};
    std::vector<Line> lines{};
};

//! `fields`, `energy`, `probes` and `lines` of a config block; places lie in the domain, from `origin` on.
OutputConfig read_output(sluice::Reader& reader, int dimension, std::array<double, 3> const& origin,
                         std::array<double, 3> const& size);

}  // namespace lbm
