#include <unordered_map>

#include "participants/dem/grain_columns.hpp"
#include "participants/dem/grain_file.hpp"

namespace dem {
namespace {

bool is_heading(std::string_view content)
{
    return !content.empty() && ((content[0] >= 'A' && content[0] <= 'Z') || (content[0] >= 'a' && content[0] <= 'z'));
}

//! `Atoms`, or `Atoms # STYLE`.
void require_spheres(Lines const& lines)
{
    auto const hash = lines.text().find('#');
    if (hash == std::string_view::npos) return;
    auto const style = trimmed(lines.text().substr(hash + 1));
    if (style != "sphere" && style != "granular")
        lines.fail("atoms are of style " + std::string(style) +
                   " (needed: sphere, that is id, type, diameter, density, x, y, z).");
}

//! Calls row() for the lines of a section, up to the next heading or the end; true: lines is at a heading.
template <class EachRow>
bool read_section(Lines& lines, std::int64_t atoms, char const* name, EachRow&& row)
{
    std::int64_t count = 0;
    bool heading = false;
    while (!heading && lines.next()) {
        auto const content = lines.content();
        if (content.empty()) continue;
        heading = is_heading(content);
        if (!heading) row(content), ++count;
    }
    if (count != atoms)
        lines.fail(std::string(name) + " end after " + std::to_string(count) + " of " + std::to_string(atoms) +
                   " rows, as the header has it. Was its writer stopped?");
    return heading;
}

//! Without and with the counts of how often a grain has left a periodic box.
Layout atoms_layout(Lines const& lines, std::string_view content)
{
    std::vector<Column> order{id_column, type_column, diameter_column, density_column, x_column, y_column, z_column};
    std::size_t words = 0;
    while (!content.empty()) take_word(content, ' '), ++words;
    if (words == 10) order.insert(order.end(), 3, no_column);
    if (words != order.size())
        lines.fail("has " + std::to_string(words) +
                   " values (needed: id, type, diameter, density, x, y, z, and 3 images or none).");
    return Layout(order);
}

struct DataFile
{
    FileGrains found;
    std::unordered_map<std::int64_t, std::size_t> index;  //!< by id
    double type = 0.0;
};

bool read_atoms(Lines& lines, std::int64_t atoms, int dimension, DataFile& data)
{
    require_spheres(lines);
    std::optional<Layout> layout;
    Row row{};
    return read_section(lines, atoms, "Atoms", [&](std::string_view content) {
        if (!layout) layout = atoms_layout(lines, content);
        layout->read(lines, content, ' ', row);
        GrainConfig const grain = grain_of(lines, *layout, row, dimension);
        if (data.found.grains.empty()) data.type = row[type_column];
        data.found.several_types = data.found.several_types || row[type_column] != data.type;
        data.index.emplace(grain.id, data.found.grains.size());
        data.found.grains.push_back(grain);
        data.found.line.push_back(lines.number());
    });
}

bool read_velocities(Lines& lines, std::int64_t atoms, int dimension, DataFile& data)
{
    Layout const layout({id_column, x_velocity, y_velocity, z_velocity, x_spin, y_spin, z_spin});
    Row row{};
    row[radius_column] = row[diameter_column] = 1.0;  // not there, and not looked at
    return read_section(lines, atoms, "Velocities", [&](std::string_view content) {
        layout.read(lines, content, ' ', row);
        GrainConfig const moves = grain_of(lines, layout, row, dimension);
        auto const found = data.index.find(moves.id);
        if (found == data.index.end())
            lines.fail("a velocity of atom " + std::to_string(moves.id) + ", which is not among the Atoms before it.");
        data.found.grains[found->second].velocity = moves.velocity;
        data.found.grains[found->second].spin = moves.spin;
    });
}

}  // namespace

FileGrains read_data(Lines lines, int dimension)
{
    DataFile data;
    std::int64_t atoms = -1;
    bool more = lines.next();  // the title
    if (auto const at = lines.text().find("units = "); more && at != std::string_view::npos)
        if (std::string_view unit = lines.text().substr(at + 8); take_word(unit, ' ') != "si")
            lines.fail("units are not si (needed: units = si).");
    bool heading = false, has_atoms = false;
    while (more) {
        if (!heading && !lines.next()) break;
        heading = false;
        std::string_view words = lines.content();
        std::string const first(take_word(words, ' '));
        if (trimmed(words) == "atoms") {
            auto const count = whole_number(first);
            if (!count || *count < 0) lines.fail("atoms = " + first + " (needed: their number).");
            atoms = *count;
        } else if (first == "Atoms") {
            if (atoms < 0) lines.fail("Atoms before their number (needed: `N atoms` in the header).");
            heading = read_atoms(lines, atoms, dimension, data);
            has_atoms = true;
        } else if (first == "Velocities") {
            heading = read_velocities(lines, atoms, dimension, data);
        }
    }
    if (!has_atoms) lines.fail("has no section Atoms (needed: `Atoms # sphere`).");
    return std::move(data.found);
}

}  // namespace dem
