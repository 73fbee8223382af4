#pragma once

#include <array>
#include <vector>

#include "participants/lbm/coverage.hpp"
#include "participants/lbm/layout.hpp"

namespace lbm {

//! Boxes around the cells that a flow reaches, close to as few cells as possible. Left out are those that solids at
//! rest cover wholly, but for those where a solid covers cells beside them in part that it covers some of, too. If too
//! little would be saved, there is one box: all.
template <int D>
std::vector<Box> live_boxes(Extent const& cells, std::array<bool, 3> const& periodic,
                            std::vector<Patch<D>> const& patches);

//! The solid that covers most of a cell, the first of equals.
template <int D>
std::int32_t solid_at(std::vector<Patch<D>> const& patches, Extent const& cell);

//! Whether solids cover a cell wholly.
template <int D>
bool is_covered(std::vector<Patch<D>> const& patches, Extent const& cell);

}  // namespace lbm
