#include "participants/dem/grain_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>
#include <unordered_map>

namespace dem {
namespace {

enum class Format
{
    csv,
    dump,
    data
};

//! By the first lines: a dump begins with an ITEM, a data file soon says `N atoms`.
Format format_of(Lines& lines)
{
    constexpr int header = 50;
    bool empty = true;
    for (int k = 0; k < header && lines.next(); ++k) {
        if (lines.text().starts_with("ITEM:")) return Format::dump;
        empty = empty && lines.content().empty();
        std::string_view words = lines.content();
        take_word(words, ' ');
        if (trimmed(words) == "atoms") return Format::data;
    }
    if (empty) lines.fail_at(1, "is empty (needed: a CSV with a header, a dump of atoms, or a data file).");
    return Format::csv;
}

FileGrains read_any(Lines lines, int dimension, std::optional<std::int64_t> timestep)
{
    auto const begin = lines.mark();
    Format const format = format_of(lines);
    lines.go_back(begin);
    if (timestep && format != Format::dump) lines.fail_at(1, "is no dump: it has no timesteps (leave timestep out).");
    if (format == Format::dump) return read_dump(std::move(lines), dimension, timestep);
    return format == Format::data ? read_data(std::move(lines), dimension) : read_csv(std::move(lines), dimension);
}

//! A grain without an id gets its place in the file.
void complete_ids(Lines const& lines, FileGrains& found)
{
    std::unordered_map<std::int64_t, std::int64_t> line_of;
    line_of.reserve(found.grains.size());
    for (std::size_t k = 0; k < found.grains.size(); ++k) {
        GrainConfig& grain = found.grains[k];
        if (grain.id < 0) grain.id = static_cast<std::int64_t>(k);
        auto const [first, fresh] = line_of.emplace(grain.id, found.line[k]);
        if (!fresh)
            lines.fail_at(found.line[k], "id = " + std::to_string(grain.id) + " is that of line " +
                                             std::to_string(first->second) + " (must be different).");
    }
}

}  // namespace

std::vector<GrainConfig> read_grain_file(std::filesystem::path const& file, int dimension,
                                         std::optional<std::int64_t> timestep, std::vector<std::string>& warnings)
{
    Lines const lines(file);
    FileGrains found = read_any(Lines(file), dimension, timestep);
    if (found.grains.empty()) lines.fail_at(1, "holds no grains (needed: at least one).");
    complete_ids(lines, found);
    if (found.several_types)
        warnings.push_back("dem: " + file.string() +
                           " has grains of several types. All of them get the one contact law of the scene.");
    return std::move(found.grains);
}

void sort_in_space(std::vector<GrainConfig>& grains)
{
    if (grains.empty()) return;
    Vec3 low = grains[0].position;
    std::vector<double> radius;
    for (GrainConfig const& g : grains) {
        for (int k = 0; k < 3; ++k) component<3>(low, k) = std::min(component(low, k), component(g.position, k));
        radius.push_back(g.radius);
    }
    auto const middle = radius.begin() + static_cast<std::ptrdiff_t>(radius.size() / 2);
    std::nth_element(radius.begin(), middle, radius.end());  // the same in any order, unlike a mean
    double const edge = 2.0 * *middle;
    auto const key = [&](GrainConfig const& g) {
        auto const cell = [&](int k) { return std::floor(component(g.position - low, k) / edge); };
        return std::tuple(cell(2), cell(1), cell(0), g.position.z, g.position.y, g.position.x, g.id);
    };
    std::sort(grains.begin(), grains.end(), [&](auto const& a, auto const& b) { return key(a) < key(b); });
}

}  // namespace dem
