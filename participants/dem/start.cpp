#include "participants/dem/start.hpp"

#include <cstdlib>
#include <optional>

#include "participants/dem/measures.hpp"

namespace dem {
namespace {

//! The box within a column, clear of its sides, in which its packing fraction is measured; nothing: too narrow.
template <int D>
std::optional<std::pair<Vec<D>, Vec<D>>> core_of(ColumnConfig const& column, Measures<D> const& m, double mean)
{
    bool const box = column.container == Container::box;
    double const side = box ? m.front - mean : 0.7 * m.front;  // a square within the quarter of a circle
    if (m.front <= 4 * mean || m.height <= 4 * mean) return std::nullopt;
    if constexpr (D == 2)
        return std::pair{Vec2{mean, mean}, Vec2{side, m.height - 2 * mean}};
    else
        return std::pair{Vec3{mean, mean, mean}, Vec3{side, box ? column.depth - mean : side, m.height - 2 * mean}};
}

}  // namespace

std::filesystem::path packing_cache()
{
    auto from = [](char const* name) { return std::getenv(name) ? std::filesystem::path(std::getenv(name)) : ""; };
    if (auto const own = from("SLUICE_CACHE"); !own.empty()) return own;
    if (auto const cache = from("XDG_CACHE_HOME"); !cache.empty()) return cache / "sluice";
    if (auto const home = from("HOME"); !home.empty()) return home / ".cache" / "sluice";
    return {};
}

std::size_t count_grains(Config const& config)
{
    return static_cast<std::size_t>(config.column ? config.column->count
                                    : config.fill ? config.fill->count
                                                  : 0) +
           config.grains.size();
}

void Start::keep(sluice::State& state) const
{
    state.put("start", std::vector<double>{height, front, mean_diameter, packing_fraction, balance});
}

Start Start::kept(sluice::State const& state)
{
    auto const numbers = state.numbers("start", 5);
    return {numbers[0], numbers[1], numbers[2], numbers[3], numbers[4]};
}

template <int D>
Start start_of(Config const& config, Solver<D> const& solver)
{
    auto const m = measure(solver);
    Start start{.height = m.height, .front = m.front, .mean_diameter = mean_diameter(solver.grains())};
    if (config.measures[Measure::drift].wanted) start.balance = solver.energies().balance();
    if (!config.column) return start;
    if (auto const core = core_of<D>(*config.column, m, start.mean_diameter))
        start.packing_fraction = packing_fraction<D>(solver.grains(), core->first, core->second);
    return start;
}

std::vector<std::pair<std::string, double>> facts_of(Config const& config, Start const& start)
{
    std::vector<std::pair<std::string, double>> facts{{"grains", static_cast<double>(count_grains(config))},
                                                      {"H0 [m]", start.height},
                                                      {"L0 [m]", start.front},
                                                      {"mean diameter [m]", start.mean_diameter},
                                                      {"longest step [s]", config.step},
                                                      {"contact time [s]", config.contact_time}};
    if (start.packing_fraction > 0) facts.emplace_back("packing fraction", start.packing_fraction);
    return facts;
}

template Start start_of<2>(Config const&, Solver<2> const&);
template Start start_of<3>(Config const&, Solver<3> const&);

}  // namespace dem
