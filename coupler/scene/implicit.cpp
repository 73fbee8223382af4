#include <algorithm>

#include "coupler/scene/parts.hpp"

namespace sluice {
namespace {

std::vector<Edge> edges_inside(Scene const& scene, ImplicitGroup const& group)
{
    std::vector<Edge> inside;
    for (Edge const& e : scene.edges)
        if (group.has(e.from) && group.has(e.to)) inside.push_back(e);
    return inside;
}

//! What a tolerance may be given for: "data" and "data.column" of what flows inside.
std::vector<std::string> tolerance_names(Scene const& scene, std::vector<Edge> const& inside)
{
    std::vector<std::string> names;
    for (Edge const& e : inside) {
        auto const& data = scene.data[static_cast<std::size_t>(e.data)];
        names.push_back(data.name);
        for (auto const& column : data.columns) names.push_back(data.name + "." + column.name);
    }
    std::sort(names.begin(), names.end());
    names.erase(std::unique(names.begin(), names.end()), names.end());
    return names;
}

void read_tolerance(Reader& reader, ImplicitGroup& group, std::vector<std::string> const& names)
{
    constexpr Bounds bounds{.above = 0.0, .below = 1.0};
    if (!reader.has("tolerance") || reader.is_scalar("tolerance")) {
        group.tolerance = reader.number_or("tolerance", group.tolerance, bounds);
        return;
    }
    auto each = reader.child_if("tolerance");
    if (!each) return;
    for (auto const& [name, value] : each->number_map(bounds)) {
        if (!names.empty() && std::find(names.begin(), names.end(), name) == names.end())
            each->problem(name, "does not flow inside this group (what does: " + list_of(names) + ")." +
                                    did_you_mean(name, names));
        group.tolerances[name] = value;
    }
}

//! Is there something to repeat a window for? Only where every name is known: else the edges are not known either.
void check_edges(Reader& reader, Scene const& scene, ImplicitGroup const& group, std::vector<Edge> const& inside)
{
    std::string names;
    for (int p : group.participants)
        names += (names.empty() ? "" : ", ") + scene.participants[static_cast<std::size_t>(p)].name;
    if (inside.empty())
        reader.problem("participants", "no coupling between " + names + ": there is nothing to iterate on.");
    else if (std::none_of(inside.begin(), inside.end(), [](Edge const& e) { return e.lag == 1; }))
        reader.problem("participants", "no coupling with lag: 1 between " + names +
                                           ": the result of one window does not come back to be corrected (give one "
                                           "of them lag: 1, or leave the group out).");
}

void check_disjoint(Reader& reader, Scene const& scene, ImplicitGroup const& group)
{
    for (ImplicitGroup const& other : scene.implicit)
        for (int p : group.participants)
            if (other.has(p))
                reader.problem("participants", scene.participants[static_cast<std::size_t>(p)].name +
                                                   " is in another group too. Make one group of both.");
}

void read_group(Reader& reader, Scene& scene, bool couplings_known)
{
    ImplicitGroup group;
    auto const mistakes = reader.diagnostics()->problems.size();
    for (auto p : reader.names_of("participants", "participant", scene.participant_names(), 2))
        group.participants.push_back(static_cast<int>(p));
    bool const members_known = couplings_known && reader.diagnostics()->problems.size() == mistakes;
    group.method = static_cast<ImplicitGroup::Method>(reader.choice_or("method", 2, {"constant", "aitken", "iqn-ils"}));
    group.relaxation = reader.number_or("relaxation", group.relaxation, {.above = 0.0, .max = 1.0});
    group.history = static_cast<int>(reader.integer_or("history", group.history, {.min = 0, .max = 1000}));
    group.max_iterations =
        static_cast<int>(reader.integer_or("max_iterations", group.max_iterations, {.min = 1, .max = 10000}));
    auto const inside = edges_inside(scene, group);
    read_tolerance(reader, group, members_known ? tolerance_names(scene, inside) : std::vector<std::string>{});
    if (members_known) check_edges(reader, scene, group, inside);
    check_disjoint(reader, scene, group);
    reader.finish();
    scene.implicit.push_back(group);
}

}  // namespace

void read_implicit(Reader& root, Scene& scene, bool couplings_known)
{
    for (auto& reader : root.list("implicit")) read_group(reader, scene, couplings_known);
}

}  // namespace sluice
