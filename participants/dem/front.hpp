#pragma once

#include <cstddef>
#include <vector>

#include "participants/dem/state.hpp"

namespace dem {

//! What the front of a round column is looked at with: sectors of one angle about the vertical axis through the origin.
struct Sectors
{
    std::size_t count = 16;
    double angle = 0.0;        //!< of all of them, from the x axis on [rad]: pi/2 for a quarter
    double percentile = 90.0;  //!< of the sectors; those that reach further are outliers
};

//! Of each sector the largest distance from the axis + R of the grains whose centre is in it [m]; 0: there is none.
std::vector<double> reach_of(Grains<3> const& grains, Sectors const& sectors);

//! Mean reach of the sectors that have a grain and do not reach further than the percentile of these (interpolated
//! between ranks) [m]; 0: no sector has a grain.
//! Source: Webb, Turnbull and Leonardi, Granular Matter (2024), doi 10.1007/s10035-024-01408-4: the grains' front from
//! 16 sectors up to the 90th percentile. We read: a sector beyond it holds a grain that rolls ahead alone.
double front_of(std::vector<double> const& reach, double percentile);

}  // namespace dem
