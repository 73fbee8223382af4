#pragma once

#include <array>
#include <filesystem>
#include <vector>

namespace files {

using Point = std::array<double, 3>;
using Triangle = std::array<Point, 3>;  //!< its corners

//! The corners of the triangles of an STL file, text or binary, in its order and its unit of length. Which of the two,
//! its content says: a text begins with `solid` and has no zero byte. A text may hold several solids; the normals that
//! a file gives are not looked at. Throws sluice::Error (config) that begins with `file:line:` (text) or `file: facet
//! N:` (binary, from 1) for a file that is cut off, a corner that is no number, a triangle without area, no triangles.
std::vector<Triangle> read_stl(std::filesystem::path const& file);

}  // namespace files
