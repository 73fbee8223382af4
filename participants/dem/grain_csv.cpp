#include <algorithm>

#include "coupler/scene/diagnostics.hpp"
#include "participants/dem/grain_columns.hpp"
#include "participants/dem/grain_file.hpp"

namespace dem {
namespace {

//! `x`, or with its unit `x [m]`.
Column header_column(Lines const& lines, std::string_view word)
{
    auto const bracket = word.find('[');
    std::string const name(trimmed(word.substr(0, bracket)));
    Column const column = column_of(name);
    auto const names = csv_names();
    if (std::find(names.begin(), names.end(), std::string(column == no_column ? name : name_of(column))) == names.end())
        lines.fail("the header has a column \"" + name + "\" (columns: " + sluice::list_of(names) + ")." +
                   (number_in(name)                                  ? " The first line must be a header."
                    : name.find_first_of(";\t") != std::string::npos ? " Columns are parted by commas."
                                                                     : sluice::did_you_mean(name, names)));
    if (bracket == std::string_view::npos) return column;
    auto const end = word.find(']');
    auto const unit = word.substr(bracket + 1, end == std::string_view::npos ? end : end - bracket - 1);
    if (unit != unit_of(column))
        lines.fail(name + " is in \"" + std::string(unit) + "\" (needed: \"" + std::string(unit_of(column)) + "\").");
    return column;
}

Layout read_header(Lines const& lines, int dimension)
{
    std::vector<Column> order;
    std::string_view rest = lines.content();
    for (bool more = true; more;) {
        more = rest.find(',') != std::string_view::npos;
        Column const column = header_column(lines, take_word(rest, ','));
        if (std::find(order.begin(), order.end(), column) != order.end())
            lines.fail("the header has two columns " + std::string(name_of(column)) + " (needed: one).");
        order.push_back(column);
    }
    Layout const layout(order);
    for (Column const column : {x_column, y_column, z_column})
        if (!layout.has(column) && (column != z_column || dimension == 3))
            lines.fail("the header has no column " + std::string(name_of(column)) + " (needed: x, y" +
                       (dimension == 3 ? ", z" : "") + ", radius or diameter).");
    if (!layout.has(radius_column) && !layout.has(diameter_column))
        lines.fail("the header has neither radius nor diameter (needed: one of them).");
    return layout;
}

}  // namespace

FileGrains read_csv(Lines lines, int dimension)
{
    FileGrains found;
    std::optional<Layout> layout;
    Row row{};
    while (lines.next()) {
        if (lines.content().empty()) continue;
        if (!layout) {
            layout = read_header(lines, dimension);
            continue;
        }
        layout->read(lines, lines.content(), ',', row);
        found.grains.push_back(grain_of(lines, *layout, row, dimension));
        found.line.push_back(lines.number());
    }
    return found;
}

}  // namespace dem
