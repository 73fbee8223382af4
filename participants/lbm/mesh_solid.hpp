#pragma once

#include <string>
#include <vector>

#include "participants/files/stl_file.hpp"
#include "participants/lbm/coverage.hpp"

namespace lbm {

//! What is wrong with a surface that should bound a solid; empty: nothing. In a closed surface every edge is gone along
//! as often one way as the other; corners of neighbours must be the same numbers.
std::string open_edges(std::vector<files::Triangle> const& surface);

//! Mean of (k1 + k2)/2 over a closed surface, k its curvatures, positive where the solid is convex [1/length]: edges
//! times half their angle, over the area. 1/R of a sphere.
double mean_curvature(std::vector<files::Triangle> const& surface);

//! The share of each cell that a closed surface bounds, exact but for rounding: the triangle's part over each cell's
//! face across x, cut at the cells' faces, is the lid of a column that reaches down x; columns under triangles that
//! face +x count, under others are taken off. Lattice units; what lies outside the lattice is left out. Either way
//! round.
Patch<3> mesh_patch(std::vector<files::Triangle> const& surface, Extent const& cells);

}  // namespace lbm
