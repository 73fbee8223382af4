#include "participants/mpm/recorder.hpp"

#include <vector>

#include "participants/mpm/measures.hpp"

namespace mpm {
namespace {

template <int D>
std::vector<std::string> headers(Extras extras)
{
    std::vector<std::string> columns{"time [s]", "run_out [m]", "foremost [m]", "height [m]"};
    char const* const unit = D == 2 && !extras.rings ? " [J/m]" : " [J]";
    for (char const* const energy : {"kinetic", "potential", "elastic", "dissipated_plastic", "dissipated_sliding",
                                     "dissipated_damping", "dissipated_numerical", "external_work", "balance"})
        columns.push_back(std::string(energy) + unit);
    for (int k = 0; k < D; ++k) columns.push_back(std::string("centre_") + "xyz"[k] + " [m]");
    columns.push_back(std::string("drift") + unit);
    if (extras.field_work) columns.push_back(std::string("field_work") + unit);
    auto const impulse = [&](std::string const& name) {
        for (int k = 0; k < D; ++k) columns.push_back(name + "_" + "xyz"[k] + (D == 2 ? " [N s/m]" : " [N s]"));
    };
    if (extras.grains) impulse("window_impulse");
    if (extras.fluid) impulse("fluid_impulse");
    return columns;
}

//! Points as columns, one array each.
template <int D>
struct Columns
{
    std::vector<std::int64_t> id;
    std::vector<double> position, velocity, stress, pressure, ratio, plastic_strain;

    explicit Columns(State<D> const& state)
    {
        for (Point<D> const& p : state.points) {
            Mat3 const& s = p.matter.stress;
            id.push_back(p.id);
            position.insert(position.end(), p.place.data(), p.place.data() + D);
            velocity.insert(velocity.end(), p.velocity.data(), p.velocity.data() + D);
            for (auto const& [i, j] : {std::pair{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {0, 2}})
                if (D == 3 || j < 2 || i == j) stress.push_back(s(i, j));
            pressure.push_back(-s.trace() / 3);
            ratio.push_back(p.matter.ratio);
            plastic_strain.push_back(p.matter.plastic_strain);
        }
    }
};

//! xx, yy, zz, xy and in space yz, xz.
template <int D>
constexpr std::size_t stresses = D == 2 ? 4 : 6;

}  // namespace

template <int D>
Recorder<D>::Recorder(sluice::RunNames const& names, Extras extras, std::optional<double> resumed_at)
    : extras_(extras),
      series_(names.directory, names.participant, sluice::Precision::float32, resumed_at),
      archive_(names.directory / (names.participant + ".h5"),
               std::vector<sluice::ArchiveFact>{{"scene_hash", std::to_string(names.scene_hash)}}, resumed_at),
      table_(names.directory / (names.participant + ".csv"), headers<D>(extras), resumed_at)
{}

template <int D>
void Recorder<D>::picture(double time, State<D> const& state)
{
    Columns<D> const c(state);
    auto const n = c.id.size();
    std::vector<sluice::PointColumn> shown{{"position", "m", D, c.position},
                                           {"velocity", "m/s", D, c.velocity},
                                           {"pressure", "Pa", 1, c.pressure},
                                           {"volume_ratio", "", 1, c.ratio},
                                           {"plastic_strain", "", 1, c.plastic_strain}};
    char const* const names[] = {"stress_xx", "stress_yy", "stress_zz", "stress_xy", "stress_yz", "stress_xz"};
    std::vector<std::vector<double>> component(stresses<D>);
    for (std::size_t k = 0; k < stresses<D>; ++k) {
        for (std::size_t p = 0; p < n; ++p) component[k].push_back(c.stress[p * stresses<D> + k]);
        shown.push_back({names[k], "Pa", 1, component[k]});
    }
    series_.append(time, c.id, shown);
    archive_.append(time,
                    std::vector<sluice::ArchiveDataset>{{"id", "", std::span<std::int64_t const>(c.id), {n}},
                                                        {"position", "m", std::span(c.position), {n, D}},
                                                        {"velocity", "m/s", std::span(c.velocity), {n, D}},
                                                        {"stress", "Pa", std::span(c.stress), {n, stresses<D>}},
                                                        {"volume_ratio", "", std::span(c.ratio), {n}},
                                                        {"plastic_strain", "", std::span(c.plastic_strain), {n}}});
}

template <int D>
void Recorder<D>::row(double time, Solver<D> const& solver, double front_depth, double balance, Vec<D> const& impulse,
                      Vec<D> const& fluid)
{
    auto const r = run_out_of(solver.setup(), solver.state(), front_depth);
    auto const e = solver.energies();
    std::vector<double> row{
        time,       r.front,          r.foremost,       r.height,         e.kinetic,          e.potential,
        e.elastic,  e.booked.plastic, e.booked.sliding, e.booked.damping, e.booked.numerical, e.booked.external_work,
        e.balance()};
    auto const centre = centre_of_mass(solver.state());
    row.insert(row.end(), centre.data(), centre.data() + D);
    row.push_back(e.balance() - balance);
    if (extras_.field_work) row.push_back(e.booked.field_work);
    if (extras_.grains) row.insert(row.end(), impulse.data(), impulse.data() + D);
    if (extras_.fluid) row.insert(row.end(), fluid.data(), fluid.data() + D);
    table_.append(row);
}

template class Recorder<2>;
template class Recorder<3>;

}  // namespace mpm
