#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "coupler/record/collection.hpp"

namespace sluice {

//! A uniform lattice of cells. In 2D cells[2] is 0 and the lattice lies in the plane z = origin[2].
struct Lattice
{
    std::array<double, 3> origin;      //!< lower corner of the first cell [m]
    std::array<double, 3> spacing;     //!< edges of a cell [m]
    std::array<std::size_t, 3> cells;  //!< cells along x, y, z

    std::size_t cell_count() const noexcept { return cells[0] * cells[1] * (cells[2] == 0 ? 1 : cells[2]); }
};

//! One quantity in every cell.
struct CellColumn
{
    std::string_view name;          //!< e.g. "vorticity"
    std::string_view unit;          //!< e.g. "1/s"; empty: not stated
    int components = 1;             //!< 1, 2 or 3 numbers per cell
    std::span<float const> values;  //!< shape [z][y][x][components], x fastest
};

//! A lattice over time for ParaView: `<directory>/<name>/<name>_000012.vti` per frame, `<directory>/<name>.pvd` over
//! all.
class ImageSeries
{
 public:
    //! Replaces an earlier series; with `keep_until` [s] goes on with it, without what came later. Throws Error
    //! (Exit::io).
    ImageSeries(std::filesystem::path directory, std::string name, Lattice const& lattice,
                std::optional<double> keep_until = std::nullopt);

    //! Adds one frame of cell data at `time` [s]. Throws Error (Exit::io); the earlier frames stay readable.
    void append(double time, std::span<CellColumn const> columns);

    std::size_t frames() const noexcept { return entries_.size(); }
    std::filesystem::path collection() const { return files_.collection(); }

 private:
    SeriesFiles files_;
    Lattice lattice_;
    std::vector<CollectionEntry> entries_;
};

}  // namespace sluice
