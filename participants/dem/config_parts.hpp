#pragma once

#include <filesystem>
#include <memory>

#include "participants/dem/config.hpp"

//! Parts of read_config that have a file of their own.
namespace dem {

//! Smallest radius [m] and mass [kg] of the grains.
struct Lightest
{
    double radius, mass;
};
Lightest lightest_grain(Config const& config);

//! `mesh` (space) or `segments` (plane), whichever the wall has; null: neither, or a broken one.
std::shared_ptr<MeshConfig const> read_mesh(sluice::Reader& wall, int dimension);

//! `packing`: grains from a file, whose path counts from the scene's.
void read_packing(sluice::Reader reader, Config& config);
//! `density`; a file may bring those of its grains instead.
void read_density(sluice::Reader& reader, Config& config);

//! `diameter`: the sizes of a column's grains.
void read_diameter(sluice::Reader reader, Config& config);

//! `lubrication`: the films of fluid in narrow gaps; once grains and step are known, whether the step resolves them.
void read_lubrication(sluice::Reader& reader, Config& config);
void check_lubrication(sluice::Reader& reader, Config& config);
//! `sleep`: grains at rest are left alone. After all that could set them in motion, and the step.
void read_sleep(sluice::Reader& reader, Config& config);

//! Looks at grains whose places are given: none behind a wall or too large for where it is (mistakes), overlaps
//! (warnings).
void check_start(sluice::Reader& reader, Config& config);

}  // namespace dem
