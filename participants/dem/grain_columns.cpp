#include "participants/dem/grain_columns.hpp"

#include <charconv>
#include <cmath>
#include <cstdio>
#include <utility>

namespace dem {
namespace {

struct Kind
{
    std::string_view name, other_name, unit;
    double min, max;
};

//! By Column. The bounds are those of a scene's own grains.
constexpr std::array<Kind, columns> kinds{{{"id", "", "", 0.0, 9e15},
                                           {"type", "", "", -9e15, 9e15},
                                           {"x", "", "m", -1e6, 1e6},
                                           {"y", "", "m", -1e6, 1e6},
                                           {"z", "", "m", -1e6, 1e6},
                                           {"xs", "", "", -1e6, 1e6},
                                           {"ys", "", "", -1e6, 1e6},
                                           {"zs", "", "", -1e6, 1e6},
                                           {"xu", "", "m", -1e6, 1e6},
                                           {"yu", "", "m", -1e6, 1e6},
                                           {"zu", "", "m", -1e6, 1e6},
                                           {"radius", "", "m", 1e-9, 1e3},
                                           {"diameter", "", "m", 2e-9, 2e3},
                                           {"density", "", "kg/m3", 1.0, 1e5},
                                           {"vx", "", "m/s", -1e4, 1e4},
                                           {"vy", "", "m/s", -1e4, 1e4},
                                           {"vz", "", "m/s", -1e4, 1e4},
                                           {"wx", "omegax", "rad/s", -1e6, 1e6},
                                           {"wy", "omegay", "rad/s", -1e6, 1e6},
                                           {"wz", "omegaz", "rad/s", -1e6, 1e6}}};

std::string seen(Column column, double value)
{
    char text[96];
    Kind const& kind = kinds[column];
    std::snprintf(text, sizeof text, "%s = %.10g%s%s", std::string(kind.name).c_str(), value,
                  kind.unit.empty() ? "" : " ", std::string(kind.unit).c_str());
    return text;
}

void check(Lines const& lines, Column column, double value)
{
    Kind const& kind = kinds[column];
    if (value >= kind.min && value <= kind.max) return;  // false for a number that is not finite
    char needed[64];
    std::snprintf(needed, sizeof needed, " (must be %g to %g).", kind.min, kind.max);
    lines.fail(seen(column, value) + needed);
}

}  // namespace

Column column_of(std::string_view name)
{
    for (std::size_t k = 0; k < columns; ++k)
        if (name == kinds[k].name || (!kinds[k].other_name.empty() && name == kinds[k].other_name))
            return static_cast<Column>(k);
    return no_column;
}

std::string_view name_of(Column column)
{
    return kinds[column].name;
}

std::string_view unit_of(Column column)
{
    return kinds[column].unit;
}

std::vector<std::string> csv_names()
{
    std::vector<std::string> names;
    for (Column const column : {id_column, x_column, y_column, z_column, radius_column, diameter_column, density_column,
                                x_velocity, y_velocity, z_velocity, x_spin, y_spin, z_spin})
        names.emplace_back(name_of(column));
    return names;
}

std::optional<std::int64_t> whole_number(std::string_view word)
{
    std::int64_t value = 0;
    auto const [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (word.empty() || error != std::errc{} || end != word.data() + word.size()) return std::nullopt;
    return value;
}

Layout::Layout(std::vector<Column> order) : order_(std::move(order))
{
    for (Column const column : order_) has_[column] = true;
    has_[no_column] = false;
}

void Layout::read(Lines const& lines, std::string_view text, char separator, Row& row) const
{
    std::size_t count = 0;
    std::string_view rest = trimmed(text);
    for (bool more = !rest.empty(); more; ++count) {
        more = separator == ' ' ? rest.find_first_of(" \t") != std::string_view::npos
                                : rest.find(separator) != std::string_view::npos;
        std::string_view const word = take_word(rest, separator);
        if (count >= order_.size() || order_[count] == no_column) continue;
        Column const column = order_[count];
        auto const value = number_in(word);
        if (!value)
            lines.fail(std::string(name_of(column)) + " = \"" + std::string(word) +
                       "\" is not a number (needed: one).");
        check(lines, column, *value);
        row[column] = *value;
    }
    if (count != order_.size())
        lines.fail("has " + std::to_string(count) + " values (needed: " + std::to_string(order_.size()) +
                   ", one for each column). Was its writer stopped?");
}

GrainConfig grain_of(Lines const& lines, Layout const& layout, Row const& row, int dimension)
{
    GrainConfig grain{};
    grain.id = layout.has(id_column) ? static_cast<std::int64_t>(row[id_column]) : -1;
    if (layout.has(id_column) && static_cast<double>(grain.id) != row[id_column])
        lines.fail(seen(id_column, row[id_column]) + " (must be a whole number).");
    grain.position = {row[x_column], row[y_column], row[z_column]};
    grain.radius = layout.has(radius_column) ? row[radius_column] : 0.5 * row[diameter_column];
    if (layout.has(radius_column) && layout.has(diameter_column) &&
        std::abs(2.0 * row[radius_column] - row[diameter_column]) > 1e-4 * row[diameter_column])
        lines.fail(seen(radius_column, row[radius_column]) + ", but " + seen(diameter_column, row[diameter_column]) +
                   " (must be twice the radius).");
    grain.density = row[density_column];
    grain.velocity = {row[x_velocity], row[y_velocity], row[z_velocity]};
    grain.spin = {row[x_spin], row[y_spin], row[z_spin]};
    if (dimension == 3) return grain;
    if (std::abs(grain.position.z) > 1e-6 * grain.radius)
        lines.fail(seen(z_column, grain.position.z) + " (must be 0: the scene is a plane).");
    for (Column const column : {z_velocity, x_spin, y_spin})
        if (row[column] != 0.0)
            lines.fail(seen(column, row[column]) + " leaves the plane (must be 0: the scene is one).");
    grain.position.z = 0.0;
    return grain;
}

}  // namespace dem
