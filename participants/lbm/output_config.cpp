#include "participants/lbm/output_config.hpp"

#include <algorithm>
#include <cstdio>

namespace lbm {
namespace {

//! The domain that places lie in.
struct Room
{
    std::size_t axes;
    std::array<double, 3> origin, size;

    std::array<double, 3> read(sluice::Reader& reader, char const* key) const
    {
        std::array<double, 3> place{};
        auto const numbers = reader.numbers(key, axes, {.unit = "m"});
        std::copy(numbers.begin(), numbers.end(), place.begin());
        for (std::size_t k = 0; k < numbers.size(); ++k) {
            if (place[k] >= origin[k] && place[k] <= origin[k] + size[k]) continue;
            char text[160];
            std::snprintf(text, sizeof text, "has %c = %g m, outside the domain (must be within %g to %g m).", "xyz"[k],
                          place[k], origin[k], origin[k] + size[k]);
            reader.problem(key, text);
        }
        return place;
    }
};

FieldChoice read_fields(sluice::Reader& reader)
{
    FieldChoice choice;
    if (!reader.has("fields")) return choice;
    std::pair<char const*, bool*> const known[] = {{"velocity", &choice.velocity},
                                                   {"pressure", &choice.pressure},
                                                   {"vorticity", &choice.vorticity},
                                                   {"solid_fraction", &choice.solid_fraction},
                                                   {"q_criterion", &choice.q_criterion}};
    for (auto const& [name, wanted] : known) *wanted = false;
    for (std::string const& word : reader.words("fields")) {
        auto const found = std::ranges::find_if(known, [&](auto const& one) { return word == one.first; });
        if (found != std::end(known))
            *found->second = true;
        else
            reader.problem("fields", word +
                                         " is none (known: velocity, pressure, vorticity, solid_fraction, "
                                         "q_criterion).");
    }
    return choice;
}

//! A name that others of its kind have not.
template <class Named>
std::string read_name(sluice::Reader& reader, std::vector<Named> const& others, char const* fallback)
{
    std::string const name = reader.word_or("name", fallback + std::to_string(others.size()));
    if (std::ranges::any_of(others, [&](Named const& other) { return other.name == name; }))
        reader.problem("name", name + " is there twice (names must differ).");
    return name;
}

}  // namespace

OutputConfig read_output(sluice::Reader& reader, int dimension, std::array<double, 3> const& origin,
                         std::array<double, 3> const& size)
{
    Room const room{static_cast<std::size_t>(dimension), origin, size};
    OutputConfig out{.fields = read_fields(reader), .energy = reader.flag_or("energy", false)};
    for (sluice::Reader& probe : reader.list("probes")) {
        std::string const name = read_name(probe, out.probes, "probe_");
        out.probes.push_back({name, room.read(probe, "at")});
        probe.finish();
    }
    for (sluice::Reader& line : reader.list("lines")) {
        std::string const name = read_name(line, out.lines, "line_");
        auto const from = room.read(line, "from"), to = room.read(line, "to");
        out.lines.push_back({name, from, to, static_cast<int>(line.integer("points", {.min = 2, .max = 1000000}))});
        line.finish();
    }
    return out;
}

}  // namespace lbm
