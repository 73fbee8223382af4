#include "participants/lbm/recorder.hpp"

#include <algorithm>

namespace lbm {
namespace {

std::vector<float> narrowed(std::vector<double> const& values)
{
    return {values.begin(), values.end()};
}

//! Of the blocks that Solver::fields() makes.
sluice::Lattice lattice_of(Config const& config, int coarsen)
{
    auto const [nx, ny, nz] = config.cells();
    double const spacing = coarsen * config.cell;
    auto const blocks = [&](std::ptrdiff_t n) { return static_cast<std::size_t>((n + coarsen - 1) / coarsen); };
    return {
        config.origin, {spacing, spacing, spacing}, {blocks(nx), blocks(ny), config.dimension == 2 ? 0 : blocks(nz)}};
}

template <int D>
std::vector<std::string> columns(Config const& config)
{
    std::string const per = D == 2 ? "/m]" : "]";
    std::vector<std::string> names{"time [s]", "max_speed [m/s]", "mass [kg" + per};
    for (std::string const what : {"momentum_", "window_impulse_"})
        for (std::size_t k = 0; k < D; ++k) names.push_back(what + "xyz"[k] + " [N s" + per);
    for (Solid const& solid : config.solids)
        for (std::size_t k = 0; k < D; ++k) names.push_back(solid.name + "_force_" + "xyz"[k] + " [N" + per);
    if (config.output.energy)
        for (char const* const name :
             {D == 2 ? "kinetic [J/m]" : "kinetic [J]", D == 2 ? "enstrophy [m2/s2]" : "enstrophy [m3/s2]"})
            names.emplace_back(name);
    for (Probe const& probe : config.output.probes) {
        names.push_back(probe.name + "_pressure [Pa]");
        for (std::size_t k = 0; k < D; ++k) names.push_back(probe.name + "_velocity_" + "xyz"[k] + " [m/s]");
    }
    return names;
}

//! Of a line's table.
template <int D>
std::vector<std::string> line_columns()
{
    std::vector<std::string> names{"time [s]"};
    for (std::size_t k = 0; k < D; ++k) names.push_back(std::string{"xyz"[k]} + " [m]");
    names.emplace_back("pressure [Pa]");
    for (std::size_t k = 0; k < D; ++k) names.push_back(std::string("velocity_") + "xyz"[k] + " [m/s]");
    names.emplace_back("solid_fraction [-]");
    return names;
}

//! A field of a picture.
struct Column
{
    char const *name, *unit;
    int components;
    std::vector<float> values;
};

template <int D>
std::vector<Column> columns_of(FieldChoice const& choice, Fields const& f)
{
    std::vector<Column> columns;
    auto const add = [&](bool wanted, char const* name, char const* unit, std::size_t components,
                         std::vector<double> const& values) {
        if (wanted) columns.push_back({name, unit, static_cast<int>(components), narrowed(values)});
    };
    add(choice.velocity, "velocity", "m/s", D, f.velocity);
    add(choice.pressure, "pressure", "Pa", 1, f.pressure);
    add(choice.vorticity, "vorticity", "1/s", spins<D>, f.vorticity);
    add(choice.solid_fraction, "solid_fraction", "", 1, f.solid_fraction);
    add(choice.q_criterion, "q_criterion", "1/s2", 1, f.q_criterion);
    return columns;
}

template <int D>
std::array<double, D> in_plane(std::array<double, 3> const& place)
{
    std::array<double, D> at;
    std::copy_n(place.begin(), D, at.begin());
    return at;
}

template <int D>
std::vector<double> first_of(std::array<double, 3> const& values)
{
    return {values.begin(), values.begin() + D};
}

}  // namespace

template <int D>
Measured<D> measured(Solver<D>& solver, std::array<double, D> const& impulse, std::vector<double> const& on_solids)
{
    OutputConfig const& wanted = solver.config().output;
    Measured<D> now{.max_speed = solver.max_speed(),
                    .mass = solver.mass(),
                    .momentum = solver.momentum(),
                    .impulse = impulse,
                    .on_solids = on_solids};
    if (wanted.energy) now.energies = solver.energies();
    std::vector<std::array<double, D>> places;
    for (Probe const& probe : wanted.probes) places.push_back(in_plane<D>(probe.place));
    for (Line const& line : wanted.lines)
        for (int k = 0; k < line.points; ++k) places.push_back(in_plane<D>(line.place(k)));
    if (places.empty()) return now;
    auto const samples = solver.samples(places);
    auto next = samples.begin() + static_cast<std::ptrdiff_t>(wanted.probes.size());
    now.probes.assign(samples.begin(), next);
    for (Line const& line : wanted.lines) {
        now.lines.emplace_back(next, next + line.points);
        next += line.points;
    }
    return now;
}
template Measured<2> measured<2>(Solver<2>&, std::array<double, 2> const&, std::vector<double> const&);
template Measured<3> measured<3>(Solver<3>&, std::array<double, 3> const&, std::vector<double> const&);

template <int D>
Recorder<D>::Recorder(sluice::RunNames const& names, Config const& config, int coarsen,
                      std::optional<double> resumed_at)
    : config_(config),
      lattice_(lattice_of(config, coarsen)),
      series_(names.directory, names.participant, lattice_, resumed_at),
      archive_(names.directory / (names.participant + ".h5"),
               std::vector<sluice::ArchiveFact>{{"scene_hash", std::to_string(names.scene_hash)},
                                                {"origin", first_of<D>(lattice_.origin)},
                                                {"spacing", first_of<D>(lattice_.spacing)}},
               resumed_at),
      table_(names.directory / (names.participant + ".csv"), columns<D>(config), resumed_at)
{
    for (Line const& line : config.output.lines)
        lines_.push_back(std::make_unique<sluice::Table>(
            names.directory / (names.participant + "." + line.name + ".csv"), line_columns<D>(), resumed_at));
}

template <int D>
void Recorder<D>::picture(double time, Fields const& f)
{
    auto const columns = columns_of<D>(config_.output.fields, f);
    std::vector<std::size_t> cells{static_cast<std::size_t>(f.ny), static_cast<std::size_t>(f.nx)};
    if constexpr (D == 3) cells.insert(cells.begin(), static_cast<std::size_t>(f.nz));
    std::vector<sluice::CellColumn> pictures;
    std::vector<sluice::ArchiveDataset> datasets;
    for (Column const& column : columns) {
        pictures.push_back({column.name, column.unit, column.components, column.values});
        auto shape = cells;
        if (column.components > 1) shape.push_back(static_cast<std::size_t>(column.components));
        datasets.push_back(
            {column.name, column.unit, std::span<float const>(column.values), shape, sluice::Pack::deflate});
    }
    series_.append(time, pictures);
    archive_.append(time, datasets);
}

template <int D>
void Recorder<D>::row(double time, Measured<D> const& now)
{
    std::vector<double> values;
    auto const add = [&](auto const& numbers) {
        for (double const number : numbers) values.push_back(number);
    };
    add(std::array{time, now.max_speed, now.mass});
    add(now.momentum);
    add(now.impulse);
    add(now.on_solids);
    if (now.energies) add(std::array{now.energies->kinetic, now.energies->enstrophy});
    for (Sample<D> const& probe : now.probes) {
        values.push_back(probe.pressure);
        add(probe.velocity);
    }
    table_.append(values);
    for (std::size_t l = 0; l < lines_.size(); ++l)
        for (int k = 0; k < config_.output.lines[l].points; ++k) {
            Sample<D> const& sample = now.lines[l][static_cast<std::size_t>(k)];
            values.assign(1, time);
            add(in_plane<D>(config_.output.lines[l].place(k)));
            values.push_back(sample.pressure);
            add(sample.velocity);
            values.push_back(sample.solid_fraction);
            lines_[l]->append(values);
        }
}

template class Recorder<2>;
template class Recorder<3>;

}  // namespace lbm
