#include "participants/dem/recorder.hpp"

#include <algorithm>
#include <utility>
#include <variant>

#include "participants/dem/contact_forces.hpp"

namespace dem {
namespace {

std::vector<std::string> with_time(std::vector<std::string> columns)
{
    columns.insert(columns.begin(), "time [s]");
    return columns;
}

//! The columns of the gauges without an interval of their own.
template <int D>
std::vector<std::string> shared_columns(std::vector<Gauge<D>> const& gauges)
{
    std::vector<std::string> columns;
    for (auto const& gauge : gauges)
        if (gauge.interval == 0.0) columns.insert(columns.end(), gauge.columns.begin(), gauge.columns.end());
    return with_time(columns);
}

//! The forces of contacts as columns: two points a contact, the centres of its grains or the grain's and the wall's.
template <int D>
struct Lines
{
    std::vector<std::int64_t> id;  //!< of the grain at each point; -1 - w: wall w
    std::vector<double> position, normal, tangential, overlap;

    explicit Lines(std::vector<ContactForce<D>> const& forces, Grains<D> const& g)
    {
        for (auto const& f : forces) {
            bool const wall = f.second >= g.size();
            id.push_back(g.id[f.first]);
            id.push_back(wall ? -1 - static_cast<std::int64_t>(f.second - g.size()) : g.id[f.second]);
            append(position, f.begin);
            append(position, f.end);
            for (auto* const end : {&normal, &tangential, &overlap}) end->resize(id.size());
            for (std::size_t at : {id.size() - 2, id.size() - 1}) {
                normal[at] = f.normal;
                tangential[at] = norm(f.tangential);
                overlap[at] = f.overlap;
            }
        }
    }
};

template <int D>
constexpr auto newton = D == 2 ? "N/m" : "N";

}  // namespace

bool is_anything_due(MeasuresConfig const& measures, Due const& due)
{
    auto const at_its_own = [&](auto const& m) { return m.wanted && m.interval > 0.0 && due.others(m.interval); };
    return due.picture || due.series || std::any_of(measures.of.begin(), measures.of.end(), at_its_own);
}

//! A dataset of the archive of measures.
template <int D>
struct Recorder<D>::Part
{
    std::string name, unit;
    std::variant<std::vector<double>, std::vector<std::int64_t>> values;
    std::vector<std::size_t> shape;

    //! A number: `column` is "height [m]".
    Part(std::string const& column, double number) : values(std::vector<double>{number})
    {
        auto const bracket = column.find(" [");
        name = column.substr(0, bracket);
        if (bracket != column.npos) unit = column.substr(bracket + 2, column.size() - bracket - 3);
    }
    template <class Value>
    Part(std::string called, std::string in, std::vector<Value> numbers, std::vector<std::size_t> sizes)
        : name(std::move(called)), unit(std::move(in)), values(std::move(numbers)), shape(std::move(sizes))
    {}
};

template <int D>
void Columns<D>::update(Grains<D> const& g)
{
    id = g.id;
    for (auto* column : {&position, &velocity, &spin, &radius, &force}) column->clear();
    for (std::size_t i = 0; i < g.size(); ++i) {
        append(position, g.place[i].centre);
        append(velocity, g.motion[i].velocity);
        append(spin, g.motion[i].spin);
        append(radius, g.place[i].radius);
        append(force, g.external[i].force);
    }
}

template <int D>
Recorder<D>::Recorder(sluice::RunNames const& names, Config const& config, double mean_diameter,
                      std::optional<double> resumed_at)
    : measures_(config.measures),
      gauges_(gauges_of<D>(config, mean_diameter)),
      series_(names.directory, names.participant, sluice::Precision::float32, resumed_at),
      archive_(names.directory / (names.participant + ".h5"),
               std::vector<sluice::ArchiveFact>{{"scene_hash", std::to_string(names.scene_hash)}}, resumed_at),
      table_(names.directory / (names.participant + ".csv"), shared_columns(gauges_), resumed_at)
{
    for (auto const& gauge : gauges_) {
        auto& own = own_.emplace_back();
        if (gauge.interval == 0.0 || gauge.columns.empty()) continue;
        own = std::make_unique<sluice::Table>(names.directory / (names.participant + "." + gauge.name + ".csv"),
                                              with_time(gauge.columns), resumed_at);
    }
    if (measures_[Measure::force_chains].wanted)
        chains_.emplace(names.directory, names.participant + ".forces", sluice::Precision::float32, resumed_at,
                        sluice::PointSeries::Cells::lines);
    if (measures_.stated)
        measured_.emplace(names.directory / (names.participant + ".measures.h5"),
                          std::vector<sluice::ArchiveFact>{{"scene_hash", std::to_string(names.scene_hash)}},
                          resumed_at);
}

template <int D>
void Recorder<D>::record(Due const& due, Columns<D> const& columns, Moment<D> const& now)
{
    if (due.picture) picture(due.time, columns, now);
    std::vector<Part> parts;
    read_gauges(due, now, parts);
    double const chains = measures_[Measure::force_chains].interval;
    if (chains_ && (chains > 0.0 ? due.others(chains) : due.picture)) read_contacts(due.time, now, parts);
    if (!measured_ || parts.empty()) return;
    std::vector<sluice::ArchiveDataset> datasets;
    for (Part const& part : parts)
        std::visit(
            [&](auto const& values) {
                datasets.push_back({part.name, part.unit, std::span(values), part.shape});
            },
            part.values);
    measured_->append(due.time, datasets);
}

template <int D>
void Recorder<D>::picture(double time, Columns<D> const& c, Moment<D> const& now)
{
    constexpr int turning = D == 2 ? 1 : 3;
    std::vector<double> diameter(c.radius);
    for (double& d : diameter) d *= 2;
    std::vector<sluice::PointColumn> shown{{"position", "m", D, c.position},
                                           {"velocity", "m/s", D, c.velocity},
                                           {"angular_velocity", "rad/s", turning, c.spin},
                                           {"radius", "m", 1, c.radius},
                                           {"diameter", "m", 1, diameter},
                                           {"fluid_force", newton<D>, D, c.force}};
    auto const n = c.id.size();
    std::vector<std::size_t> const spins = D == 2 ? std::vector<std::size_t>{n} : std::vector<std::size_t>{n, 3};
    std::vector<sluice::ArchiveDataset> kept{{"id", "", std::span<std::int64_t const>(c.id), {n}},
                                             {"position", "m", std::span(c.position), {n, D}},
                                             {"velocity", "m/s", std::span(c.velocity), {n, D}},
                                             {"angular_velocity", "rad/s", std::span(c.spin), spins},
                                             {"radius", "m", std::span(c.radius), {n}},
                                             {"fluid_force", newton<D>, std::span(c.force), {n, D}}};
    if (measures_[Measure::voronoi].wanted) {
        auto const& fraction = now.cells().fraction;
        shown.push_back({"packing_fraction", "", 1, fraction});
        kept.push_back({"packing_fraction", "", std::span(fraction), {n}});
    }
    series_.append(time, c.id, shown);
    archive_.append(time, kept);
}

template <int D>
void Recorder<D>::read_gauges(Due const& due, Moment<D> const& now, std::vector<Part>& parts)
{
    std::vector<double> row{due.time};
    for (std::size_t k = 0; k < gauges_.size(); ++k) {
        Gauge<D> const& gauge = gauges_[k];
        if (!(gauge.interval > 0.0 ? due.others(gauge.interval) : due.series)) continue;
        std::vector<double> numbers;
        std::vector<Array> arrays;
        gauge.read(now, numbers, arrays);
        for (std::size_t c = 0; c < numbers.size(); ++c) parts.emplace_back(gauge.columns[c], numbers[c]);
        for (auto& array : arrays) {
            auto const size = array.values.size();
            parts.emplace_back(array.name, array.unit, std::move(array.values), std::vector{size});
        }
        if (gauge.interval == 0.0) row.insert(row.end(), numbers.begin(), numbers.end());
        if (own_[k]) {
            numbers.insert(numbers.begin(), due.time);
            own_[k]->append(numbers);
        }
    }
    if (due.series) table_.append(row);
}

template <int D>
void Recorder<D>::read_contacts(double time, Moment<D> const& now, std::vector<Part>& parts)
{
    auto const forces = contact_forces(now.solver.setup(), now.solver.state());
    Lines<D> const lines(forces, now.grains());
    chains_->append(time, lines.id,
                    std::vector<sluice::PointColumn>{{"position", "m", D, lines.position},
                                                     {"normal_force", newton<D>, 1, lines.normal},
                                                     {"tangential_force", newton<D>, 1, lines.tangential},
                                                     {"overlap", "m", 1, lines.overlap}});
    std::size_t const n = forces.size();
    std::vector<double> force, overlap;
    for (auto const& f : forces) {
        append(force, f.force());
        overlap.push_back(f.overlap);
    }
    parts.emplace_back("contact_ids", "", lines.id, std::vector<std::size_t>{n, 2});
    parts.emplace_back("contact_force", newton<D>, std::move(force), std::vector<std::size_t>{n, D});
    parts.emplace_back("contact_overlap", "m", std::move(overlap), std::vector<std::size_t>{n});
}

template <int D>
void Recorder<D>::close()
{
    archive_.close();
    if (measured_) measured_->close();
}

template struct Columns<2>;
template struct Columns<3>;
template class Recorder<2>;
template class Recorder<3>;

}  // namespace dem
