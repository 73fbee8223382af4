#include "coupler/record/image_series.hpp"

#include <fmt/format.h>

#include <cassert>

#include "coupler/record/atomic_file.hpp"
#include "coupler/record/vtk_xml.hpp"

namespace sluice {
namespace {

std::string document(Lattice const& lattice, std::span<CellColumn const> columns)
{
    AppendedArrays arrays;
    std::string cell_data;
    for (auto const& column : columns) {
        assert(column.values.size() == lattice.cell_count() * static_cast<std::size_t>(column.components));
        cell_data += arrays.add_padded(column.name, column.unit, column.components, column.values);
    }
    std::string const extent = fmt::format("0 {} 0 {} 0 {}", lattice.cells[0], lattice.cells[1], lattice.cells[2]);
    auto const triple = [](std::array<double, 3> const& v) { return fmt::format("{} {} {}", v[0], v[1], v[2]); };
    return arrays.document("ImageData",
                           fmt::format("<ImageData WholeExtent=\"{0}\" Origin=\"{1}\" Spacing=\"{2}\">\n"
                                       "<Piece Extent=\"{0}\">\n<CellData>\n{3}</CellData>\n</Piece>\n</ImageData>\n",
                                       extent, triple(lattice.origin), triple(lattice.spacing), cell_data));
}

}  // namespace

ImageSeries::ImageSeries(std::filesystem::path directory, std::string name, Lattice const& lattice,
                         std::optional<double> keep_until)
    : files_{std::move(directory), std::move(name), "vti"},
      lattice_(lattice),
      entries_(begin_series(files_, keep_until))
{}

void ImageSeries::append(double time, std::span<CellColumn const> columns)
{
    std::string const file = files_.frame(entries_.size());
    write_atomically(files_.directory / file, document(lattice_, columns));
    entries_.push_back({.time = time, .part = 0, .file = file});
    write_collection(collection(), entries_);
}

}  // namespace sluice
