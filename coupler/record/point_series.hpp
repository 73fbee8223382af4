#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "coupler/record/collection.hpp"
#include "coupler/record/vtk_xml.hpp"

namespace sluice {

//! One quantity at N points.
struct PointColumn
{
    std::string_view name;           //!< e.g. "velocity"
    std::string_view unit;           //!< e.g. "m/s"; empty: not stated
    int components = 1;              //!< 1, 2 or 3 numbers per point
    std::span<double const> values;  //!< shape [N][components]
};

//! Points over time for ParaView: `<directory>/<name>/<name>_000012.vtp` per frame and `<directory>/<name>.pvd` over
//! all. N may change from frame to frame and may be 0. 2D vectors get z = 0.
class PointSeries
{
 public:
    enum class Cells
    {
        vertices,
        lines
    };  //!< lines: one from each even point to the next; N is even

    //! Replaces an earlier series; with `keep_until` [s] goes on with it, without what came later. Throws Error
    //! (Exit::io).
    PointSeries(std::filesystem::path directory, std::string name, Precision precision = Precision::float64,
                std::optional<double> keep_until = std::nullopt, Cells cells = Cells::vertices);

    //! Adds one frame at `time` [s]. `ids` has N entries; one column must be "position" (2 or 3 components, metres),
    //! the others become point data. Throws Error (Exit::io); the earlier frames stay readable.
    void append(double time, std::span<std::int64_t const> ids, std::span<PointColumn const> columns);

    std::size_t frames() const noexcept { return entries_.size(); }
    std::filesystem::path collection() const { return files_.collection(); }

 private:
    SeriesFiles files_;
    Precision precision_;
    Cells cells_;
    std::vector<CollectionEntry> entries_;
};

}  // namespace sluice
