#include "participants/dem/gauges.hpp"

#include <algorithm>

#include "participants/dem/measures.hpp"
#include "participants/dem/series_averages.hpp"

namespace dem {
namespace {

using Numbers = std::vector<double>;
using Arrays = std::vector<Array>;

template <int D>
std::vector<std::string> axes(std::string const& name, std::string const& unit)
{
    std::vector<std::string> columns;
    for (int k = 0; k < D; ++k) columns.push_back(name + "xyz"[k] + unit);
    return columns;
}
template <int D>
std::string joule()
{
    return D == 2 ? " [J/m]" : " [J]";
}

template <int D>
Gauge<D> run_out()
{
    return {{"run_out [m]", "foremost [m]", "height [m]"}, [](Moment<D> const& now, Numbers& numbers, Arrays&) {
                auto const r = run_out_of(now.grains());
                numbers.insert(numbers.end(), {r.front, r.foremost, r.height});
            }};
}

//! Whether gravity or the frame does during the run.
bool changes(Config const& config)
{
    return config.gravity_ramp > 0.0 || (config.rotation && config.rotation->ramp > 0.0);
}

template <int D>
Gauge<D> energies(bool field_changes)
{
    std::vector<std::string> columns;
    for (auto const energy :
         {"kinetic", "rotational", "potential", "elastic", "dissipated_normal", "dissipated_tangential",
          "dissipated_sliding", "dissipated_rolling", "vanished", "fluid_work", "wall_work", "balance"})
        columns.push_back(energy + joule<D>());
    if (field_changes) columns.push_back("field_work" + joule<D>());
    return {columns, [field_changes](Moment<D> const& now, Numbers& numbers, Arrays&) {
                auto const e = now.solver.energies();
                numbers.insert(numbers.end(), {e.kinetic_linear, e.kinetic_rotational, e.potential, e.elastic(),
                                               e.normal_dashpot, e.tangential_dashpot, e.sliding, e.rolling,
                                               e.removed_walls + e.touch, e.external_work, e.wall_work, e.balance()});
                if (field_changes) numbers.push_back(e.field_work);
            }};
}

template <int D>
Gauge<D> contacts()
{
    return {{"coordination", "contacts", "largest_overlap"}, [](Moment<D> const& now, Numbers& numbers, Arrays&) {
                auto const& setup = now.solver.setup();
                auto const& state = now.solver.state();
                auto const n = contact_numbers(setup, state);
                auto const each = contacts_of_grains(setup, state, Partners::grains_and_walls);
                numbers.insert(numbers.end(),
                               {coordination_of(each, 0).bearing, static_cast<double>(n.contacts), n.largest_overlap});
            }};
}

template <int D>
Gauge<D> centre()
{
    return {axes<D>("centre_", " [m]"),
            [](Moment<D> const& now, Numbers& numbers, Arrays&) { append(numbers, centre_of_mass(now.grains())); }};
}

template <int D>
Gauge<D> impulse()
{
    return {axes<D>("window_impulse_", D == 2 ? " [N s/m]" : " [N s]"),
            [](Moment<D> const& now, Numbers& numbers, Arrays&) { append(numbers, now.impulse); }};
}

template <int D>
Gauge<D> drift()
{
    return {{"drift" + joule<D>()}, [](Moment<D> const& now, Numbers& numbers, Arrays&) {
                numbers.push_back(now.solver.energies().balance() - now.balance);
            }};
}

Gauge<3> front(Sectors const& sectors)
{
    return {{"front [m]"}, [sectors](Moment<3> const& now, Numbers& numbers, Arrays& arrays) {
                auto const reach = reach_of(now.grains(), sectors);
                numbers.push_back(front_of(reach, sectors.percentile));
                arrays.push_back({"front_sectors", "m", reach});
            }};
}

template <int D>
Gauge<D> coordination(std::size_t most, Partners partners)
{
    std::vector<std::string> columns{"contacts_mean", "contacts_bearing", "rattlers"};
    for (std::size_t k = 0; k <= most; ++k) columns.push_back("with_" + std::to_string(k));
    return {columns, [most, partners](Moment<D> const& now, Numbers& numbers, Arrays& arrays) {
                auto const each = contacts_of_grains(now.solver.setup(), now.solver.state(), partners);
                auto const c = coordination_of(each, most);
                double const all = static_cast<double>(std::max<std::size_t>(each.size(), 1));
                numbers.insert(numbers.end(), {c.mean, c.bearing, static_cast<double>(c.rattlers) / all});
                numbers.insert(numbers.end(), c.grains.begin(), c.grains.end());
                arrays.push_back({"grains_with", "", c.grains});
            }};
}

template <int D>
Gauge<D> profile(Bins const& bins)
{
    return {{}, [bins](Moment<D> const& now, Numbers&, Arrays& arrays) {
                auto p = profile_of(now.grains(), bins);
                arrays.push_back({"profile_position", "m", std::move(p.position)});
                arrays.push_back({"profile_mass", D == 2 ? "kg/m" : "kg", std::move(p.mass)});
                arrays.push_back({"profile_surface", "m", std::move(p.surface)});
            }};
}

template <int D>
Gauge<D> voronoi(Bins const& bins)
{
    return {{"packing_fraction", "closed_cells"}, [bins](Moment<D> const& now, Numbers& numbers, Arrays& arrays) {
                auto p = packed_of(now.grains(), now.cells(), bins);
                numbers.insert(numbers.end(), {p.fraction, static_cast<double>(p.closed)});
                arrays.push_back({"packing_position", "m", std::move(p.position)});
                arrays.push_back({"packing_profile", "", std::move(p.fractions)});
            }};
}

template <int D>
Gauge<D> gauge_of(Measure which, Config const& config, double mean_diameter)
{
    MeasuresConfig const& m = config.measures;
    Bins const bins{m.slice > 0.0 ? m.slice : 2.0 * mean_diameter, m.radial};
    switch (which) {
        case Measure::run_out:
            return run_out<D>();
        case Measure::energies:
            return energies<D>(changes(config));
        case Measure::contacts:
            return contacts<D>();
        case Measure::centre:
            return centre<D>();
        case Measure::impulse:
            return impulse<D>();
        case Measure::drift:
            return drift<D>();
        case Measure::coordination:
            return coordination<D>(m.most_contacts, m.wall_contacts ? Partners::grains_and_walls : Partners::grains);
        case Measure::profile:
            return profile<D>(bins);
        case Measure::voronoi:
            return voronoi<D>(bins);
        case Measure::front:
            if constexpr (D == 3) return front(m.sectors);
            break;
        case Measure::force_chains:
            break;
    }
    return {};
}

}  // namespace

template <int D>
std::vector<Gauge<D>> gauges_of(Config const& config, double mean_diameter)
{
    MeasuresConfig const& measures = config.measures;
    std::vector<Gauge<D>> gauges;
    for (std::size_t k = 0; k < measure_names.size(); ++k) {
        if (!measures.of[k].wanted) continue;
        auto gauge = gauge_of<D>(static_cast<Measure>(k), config, mean_diameter);
        if (!gauge.read) continue;  // force chains are no numbers
        gauge.name = measure_names[k];
        gauge.interval = measures.of[k].interval;
        gauges.push_back(std::move(gauge));
    }
    if (!config.averages.empty())
        gauges.push_back({average_names<D>(config), [config](Moment<D> const& now, Numbers& numbers, Arrays&) {
                              append_averages(config, now.solver, numbers);
                          }});
    return gauges;
}

template std::vector<Gauge<2>> gauges_of<2>(Config const&, double);
template std::vector<Gauge<3>> gauges_of<3>(Config const&, double);

}  // namespace dem
