#include "participants/lbm/recorder.hpp"

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
    return names;
}

template <int D>
std::vector<double> first_of(std::array<double, 3> const& values)
{
    return {values.begin(), values.begin() + D};
}

}  // namespace

template <int D>
Recorder<D>::Recorder(sluice::RunNames const& names, Config const& config, int coarsen,
                      std::optional<double> resumed_at)
    : lattice_(lattice_of(config, coarsen)),
      series_(names.directory, names.participant, lattice_, resumed_at),
      archive_(names.directory / (names.participant + ".h5"),
               std::vector<sluice::ArchiveFact>{{"scene_hash", std::to_string(names.scene_hash)},
                                                {"origin", first_of<D>(lattice_.origin)},
                                                {"spacing", first_of<D>(lattice_.spacing)}},
               resumed_at),
      table_(names.directory / (names.participant + ".csv"), columns<D>(config), resumed_at)
{}

template <int D>
void Recorder<D>::picture(double time, Fields const& f)
{
    auto const velocity = narrowed(f.velocity), pressure = narrowed(f.pressure), vorticity = narrowed(f.vorticity),
               solid = narrowed(f.solid_fraction);
    series_.append(time, std::vector<sluice::CellColumn>{{"velocity", "m/s", D, velocity},
                                                         {"pressure", "Pa", 1, pressure},
                                                         {"vorticity", "1/s", spins<D>, vorticity},
                                                         {"solid_fraction", "", 1, solid}});
    std::vector<std::size_t> cells{static_cast<std::size_t>(f.ny), static_cast<std::size_t>(f.nx)};
    if constexpr (D == 3) cells.insert(cells.begin(), static_cast<std::size_t>(f.nz));
    auto const dataset = [&](char const* name, char const* unit, std::vector<float> const& values,
                             std::size_t components) {
        auto shape = cells;
        if (components > 1) shape.push_back(components);
        return sluice::ArchiveDataset{name, unit, std::span<float const>(values), shape, sluice::Pack::deflate};
    };
    archive_.append(time, std::vector<sluice::ArchiveDataset>{dataset("velocity", "m/s", velocity, D),
                                                              dataset("pressure", "Pa", pressure, 1),
                                                              dataset("vorticity", "1/s", vorticity, spins<D>),
                                                              dataset("solid_fraction", "", solid, 1)});
}

template <int D>
void Recorder<D>::row(double time, Measured<D> const& now)
{
    std::vector<double> values{time, now.max_speed, now.mass};
    values.insert(values.end(), now.momentum.begin(), now.momentum.end());
    values.insert(values.end(), now.impulse.begin(), now.impulse.end());
    values.insert(values.end(), now.on_solids.begin(), now.on_solids.end());
    table_.append(values);
}

template class Recorder<2>;
template class Recorder<3>;

}  // namespace lbm
