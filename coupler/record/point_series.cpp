#include "coupler/record/point_series.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <numeric>

#include "coupler/base/error.hpp"
#include "coupler/record/atomic_file.hpp"

namespace sluice {
namespace {

PointColumn const& find_position(std::span<PointColumn const> columns, std::string const& series)
{
    auto const found = std::ranges::find(columns, std::string_view("position"), &PointColumn::name);
    require(found != columns.end() && found->components >= 2, [&] {
        return Error(
            fmt::format("{}: the frame has no column \"position\" with 2 or 3 components (needed to place "
                        "the points). Add it in the participant that writes this series.",
                        series));
    });
    return *found;
}

//! Cells of `each` points in their order: connectivity 0..N-1, offsets each, 2 each, ..., N.
std::string cells_of(AppendedArrays& arrays, std::size_t count, std::size_t each)
{
    std::vector<std::int64_t> numbers(count);
    std::iota(numbers.begin(), numbers.end(), std::int64_t{0});
    std::string text = arrays.add("connectivity", "", 1, numbers);
    numbers.clear();
    for (std::size_t end = each; end <= count; end += each) numbers.push_back(static_cast<std::int64_t>(end));
    return text + arrays.add("offsets", "", 1, numbers);
}

std::string document(std::span<std::int64_t const> ids, std::span<PointColumn const> columns,
                     PointColumn const& position, Precision precision, PointSeries::Cells cells)
{
    bool const lines = cells == PointSeries::Cells::lines;
    std::size_t const each = lines ? 2 : 1, count = ids.size() / each;
    AppendedArrays arrays;
    std::string point_data = arrays.add("id", "", 1, ids);
    for (auto const& column : columns) {
        assert(column.values.size() == ids.size() * static_cast<std::size_t>(column.components));
        if (&column != &position)
            point_data += arrays.add_padded(column.name, column.unit, column.components, column.values, precision);
    }
    std::string const points = arrays.add_padded("position", "m", position.components, position.values, precision);
    return arrays.document(
        "PolyData", fmt::format("<PolyData>\n<Piece NumberOfPoints=\"{0}\" NumberOfVerts=\"{1}\" NumberOfLines=\"{2}\" "
                                "NumberOfStrips=\"0\" NumberOfPolys=\"0\">\n<PointData>\n{3}</PointData>\n"
                                "<Points>\n{4}</Points>\n<{5}>\n{6}</{5}>\n</Piece>\n</PolyData>\n",
                                ids.size(), lines ? 0 : count, lines ? count : 0, point_data, points,
                                lines ? "Lines" : "Verts", cells_of(arrays, ids.size(), each)));
}

}  // namespace

PointSeries::PointSeries(std::filesystem::path directory, std::string name, Precision precision,
                         std::optional<double> keep_until, Cells cells)
    : files_{std::move(directory), std::move(name), "vtp"},
      precision_(precision),
      cells_(cells),
      entries_(begin_series(files_, keep_until))
{}

void PointSeries::append(double time, std::span<std::int64_t const> ids, std::span<PointColumn const> columns)
{
    PointColumn const& position = find_position(columns, files_.name);
    std::string const file = files_.frame(entries_.size());
    write_atomically(files_.directory / file, document(ids, columns, position, precision_, cells_));
    entries_.push_back({.time = time, .part = 0, .file = file});
    write_collection(collection(), entries_);
}

}  // namespace sluice
