#include <array>
#include <cmath>

#include "participants/dem/grain_columns.hpp"
#include "participants/dem/grain_file.hpp"

namespace dem {
namespace {

struct Box
{
    std::array<double, 3> low{}, high{};
    std::array<bool, 3> periodic{};
    bool oblique = false;
};

//! The frames of a dump: the one that is wanted, and what there is.
struct Frames
{
    Lines::Mark wanted;
    std::int64_t count = 0, first = 0, last = 0;
    bool found = false;

    std::string there() const
    {
        return count == 1 ? "the only frame is that of timestep " + std::to_string(first)
                          : std::to_string(count) + " frames from timestep " + std::to_string(first) + " to " +
                                std::to_string(last);
    }
};

std::string_view item_of(Lines const& lines)
{
    constexpr std::string_view head = "ITEM: ";
    return lines.text().starts_with(head) ? trimmed(lines.text().substr(head.size())) : std::string_view{};
}

std::int64_t read_count(Lines& lines, char const* what)
{
    auto const count = lines.next() ? whole_number(trimmed(lines.text())) : std::nullopt;
    if (!count || *count < 0) lines.fail(std::string("has no ") + what + " (needed: a whole number).");
    return *count;
}

Frames find_frames(Lines& lines, std::optional<std::int64_t> timestep)
{
    Frames frames;
    while (lines.next()) {
        if (item_of(lines) == "UNITS" && lines.next() && trimmed(lines.text()) != "si")
            lines.fail("units are " + std::string(trimmed(lines.text())) + " (needed: si).");
        if (item_of(lines) != "TIMESTEP") continue;
        frames.last = read_count(lines, "timestep");
        if (frames.count++ == 0) frames.first = frames.last;
        if (timestep && frames.last != *timestep) continue;
        frames.wanted = lines.mark();
        frames.found = true;
    }
    if (frames.count == 0) lines.fail("has no ITEM: TIMESTEP (needed: a dump of atoms).");
    if (!frames.found)
        lines.fail("no frame is of timestep " + std::to_string(*timestep) + " (there: " + frames.there() + ").");
    return frames;
}

Box read_box(Lines& lines, std::string_view flags)
{
    Box box;
    std::size_t axis = 0;
    for (std::string_view flag = take_word(flags, ' '); !flag.empty(); flag = take_word(flags, ' ')) {
        if (flag == "xy" || flag == "xz" || flag == "yz")
            box.oblique = true;
        else if (axis < 3)
            box.periodic[axis++] = flag == "pp";
    }
    for (axis = 0; axis < 3; ++axis) {
        std::string_view rest = lines.next() ? trimmed(lines.text()) : std::string_view{};
        auto const low = number_in(take_word(rest, ' ')), high = number_in(take_word(rest, ' '));
        if (!low || !high || !(*high >= *low)) lines.fail("is no side of a box (needed: two numbers, ascending).");
        box.low[axis] = *low;
        box.high[axis] = *high;
    }
    return box;
}

Layout read_columns(std::string_view names)
{
    std::vector<Column> order;
    for (std::string_view name = take_word(names, ' '); !name.empty(); name = take_word(names, ' '))
        order.push_back(column_of(name));
    return Layout(order);
}

void require_columns(Lines const& lines, Layout const& layout, Box const& box, int dimension)
{
    constexpr std::array<char const*, 3> axes{"x", "y", "z"};
    for (std::size_t axis = 0; axis < static_cast<std::size_t>(dimension); ++axis) {
        auto const has = [&](Column of_x) { return layout.has(static_cast<Column>(of_x + axis)); };
        std::string const x = axes[axis];
        if (!has(x_column) && !has(x_scaled) && !has(x_unwound))
            lines.fail("has no column " + x + ", " + x + "s or " + x + "u (needed: one of them).");
        if (box.oblique && !has(x_column))
            lines.fail("has " + (has(x_scaled) ? x + "s" : x + "u") + " in an oblique box (needed: column " + x + ").");
    }
    if (!layout.has(radius_column) && !layout.has(diameter_column))
        lines.fail("has neither radius nor diameter (needed: one of them; dump custom ... id type x y z radius).");
}

//! Sets x, y, z of a row from what the dump has: places, parts of the box, or places that left a periodic box.
void place_in(Box const& box, Layout const& layout, Row& row)
{
    for (std::size_t axis = 0; axis < 3; ++axis) {
        double const length = box.high[axis] - box.low[axis];
        double& x = row[x_column + axis];
        if (layout.has(static_cast<Column>(x_column + axis))) continue;
        if (layout.has(static_cast<Column>(x_scaled + axis))) {
            x = box.low[axis] + row[x_scaled + axis] * length;
        } else if (layout.has(static_cast<Column>(x_unwound + axis))) {
            x = row[x_unwound + axis];
            if (box.periodic[axis] && length > 0.0) x -= std::floor((x - box.low[axis]) / length) * length;
        }
    }
}

}  // namespace

FileGrains read_dump(Lines lines, int dimension, std::optional<std::int64_t> timestep)
{
    Frames const frames = find_frames(lines, timestep);
    lines.go_back(frames.wanted);
    Box box;
    std::int64_t count = -1;
    while (lines.next() && !item_of(lines).starts_with("ATOMS")) {
        if (item_of(lines).starts_with("TIMESTEP"))
            lines.fail("has no ITEM: ATOMS before it (needed: a dump of atoms).");
        if (item_of(lines) == "NUMBER OF ATOMS") count = read_count(lines, "number of atoms");
        constexpr std::string_view bounds = "BOX BOUNDS";
        if (item_of(lines).starts_with(bounds)) {
            std::string const flags(trimmed(item_of(lines).substr(bounds.size())));
            box = read_box(lines, flags);
        }
    }
    if (!item_of(lines).starts_with("ATOMS") || count < 0)
        lines.fail("has no NUMBER OF ATOMS and ITEM: ATOMS (needed: a dump of atoms; " + frames.there() + ").");
    Layout const layout = read_columns(trimmed(item_of(lines).substr(5)));
    require_columns(lines, layout, box, dimension);

    FileGrains found;
    Row row{};
    double type = 0.0;
    for (std::int64_t k = 0; k < count; ++k) {
        if (!lines.next() || !item_of(lines).empty())
            lines.fail("the frame ends after " + std::to_string(k) + " of " + std::to_string(count) +
                       " grains. Was its writer stopped? Give the timestep of another frame (there: " + frames.there() +
                       ").");
        layout.read(lines, lines.text(), ' ', row);
        place_in(box, layout, row);
        found.grains.push_back(grain_of(lines, layout, row, dimension));
        found.line.push_back(lines.number());
        if (k == 0) type = row[type_column];
        found.several_types = found.several_types || row[type_column] != type;
    }
    return found;
}

}  // namespace dem
