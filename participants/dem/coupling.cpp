#include "participants/dem/coupling.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>

#include "coupler/coupler.hpp"
#include "coupler/record/archive.hpp"
#include "coupler/record/point_series.hpp"
#include "coupler/record/table.hpp"
#include "participants/dem/checkpoint.hpp"
#include "participants/dem/measures.hpp"
#include "participants/dem/series_averages.hpp"
#include "participants/dem/setup.hpp"
#include "participants/dem/steady_shear.hpp"

namespace dem {
namespace {

constexpr double steps_of_a_dry_window = 50;  // without a partner a window only paces the output

//! Packings are kept between runs here; empty: nowhere.
std::filesystem::path packing_cache()
{
    auto from = [](char const* name) { return std::getenv(name) ? std::filesystem::path(std::getenv(name)) : ""; };
    if (auto const own = from("SLUICE_CACHE"); !own.empty()) return own;
    if (auto const cache = from("XDG_CACHE_HOME"); !cache.empty()) return cache / "sluice";
    if (auto const home = from("HOME"); !home.empty()) return home / ".cache" / "sluice";
    return {};
}

//! A vector's numbers at the end of a list.
template <class V>
void append(std::vector<double>& to, V v)
{
    each_number(v, [&](double number) { to.push_back(number); });
}

//! The grains as columns for frames, files and archives: interleaved, as all of those want them.
template <int D>
struct Columns
{
    std::vector<std::int64_t> id;
    std::vector<double> position, velocity, spin, radius, force;

    void update(Grains<D> const& g)
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
    sluice::Kinematics kinematics() const { return {id, position, velocity, spin, radius}; }
};

//! What a run leaves behind: ParaView series, HDF5 archive, time series. A resumed run goes on with what is there up to
//! `resumed_at` [s].
template <int D>
class Recorder
{
 public:
    Recorder(sluice::Participant& self, Config const& config, std::optional<double> resumed_at = std::nullopt)
        : config_(config),
          series_(self.directory(), self.name(), sluice::Precision::float32, resumed_at),
          archive_(self.directory() / (self.name() + ".h5"),
                   std::vector<sluice::ArchiveFact>{{"scene_hash", std::to_string(self.scene().hash)}}, resumed_at),
          table_(self.directory() / (self.name() + ".csv"), headers(config), resumed_at)
    {
        if (auto const remark = archive_.remark(series_.frames()); !remark.empty()) self.warn(remark);
    }

    void picture(double time, Columns<D> const& c)
    {
        constexpr int turning = D == 2 ? 1 : 3;
        constexpr auto force = D == 2 ? "N/m" : "N";
        std::vector<double> diameter(c.radius);
        for (double& d : diameter) d *= 2;
        series_.append(time, c.id,
                       std::vector<sluice::PointColumn>{{"position", "m", D, c.position},
                                                        {"velocity", "m/s", D, c.velocity},
                                                        {"angular_velocity", "rad/s", turning, c.spin},
                                                        {"radius", "m", 1, c.radius},
                                                        {"diameter", "m", 1, diameter},
                                                        {"fluid_force", force, D, c.force}});
        auto const n = c.id.size();
        std::vector<std::size_t> const spins = D == 2 ? std::vector<std::size_t>{n} : std::vector<std::size_t>{n, 3};
        archive_.append(time,
                        std::vector<sluice::ArchiveDataset>{{"id", "", std::span<std::int64_t const>(c.id), {n}},
                                                            {"position", "m", std::span(c.position), {n, D}},
                                                            {"velocity", "m/s", std::span(c.velocity), {n, D}},
                                                            {"angular_velocity", "rad/s", std::span(c.spin), spins},
                                                            {"radius", "m", std::span(c.radius), {n}},
                                                            {"fluid_force", force, std::span(c.force), {n, D}}});
    }

    void row(double time, Solver<D> const& solver, Vec<D> impulse)
    {
        auto const m = measure(solver);
        auto const e = solver.energies();
        std::vector<double> values{time,
                                   m.front,
                                   m.foremost,
                                   m.height,
                                   e.kinetic_linear,
                                   e.kinetic_rotational,
                                   e.potential,
                                   e.elastic(),
                                   e.normal_dashpot,
                                   e.tangential_dashpot,
                                   e.sliding,
                                   e.rolling,
                                   e.removed_walls + e.touch,
                                   e.external_work,
                                   e.wall_work,
                                   e.balance(),
                                   m.coordination,
                                   static_cast<double>(m.contacts),
                                   m.largest_overlap};
        append(values, m.centre_of_mass);
        append(values, impulse);
        append_averages(config_, solver, values);
        table_.append(values);
    }

    void close() { archive_.close(); }

 private:
    static std::vector<std::string> headers(Config const& config)
    {
        std::string const joule = D == 2 ? " [J/m]" : " [J]", impulse = D == 2 ? " [N s/m]" : " [N s]";
        std::vector<std::string> names{"time [s]", "run_out [m]", "foremost [m]", "height [m]"};
        for (auto const energy :
             {"kinetic", "rotational", "potential", "elastic", "dissipated_normal", "dissipated_tangential",
              "dissipated_sliding", "dissipated_rolling", "vanished", "fluid_work", "wall_work", "balance"})
            names.push_back(energy + joule);
        for (auto const name : {"coordination", "contacts", "largest_overlap"}) names.push_back(name);
        for (int k = 0; k < D; ++k) names.push_back(std::string("centre_") + "xyz"[k] + " [m]");
        for (int k = 0; k < D; ++k)  // that the fluid gave in the last window
            names.push_back(std::string("window_impulse_") + "xyz"[k] + impulse);
        for (auto const& name : average_names<D>(config)) names.push_back(name);
        return names;
    }

    Config const& config_;
    sluice::PointSeries series_;
    sluice::Archive archive_;
    sluice::Table table_;
};

//! Where a grain of a lasting id is in the solver's arrays.
class Finder
{
 public:
    explicit Finder(std::vector<std::int64_t> const& id) : count_(id.size())
    {
        for (std::size_t i = 0; i < id.size(); ++i) is_plain_ = is_plain_ && id[i] == static_cast<std::int64_t>(i);
        if (!is_plain_)
            for (std::size_t i = 0; i < id.size(); ++i) index_.emplace(id[i], i);
    }
    std::size_t operator()(std::int64_t id) const
    {
        if (is_plain_ && id >= 0 && static_cast<std::size_t>(id) < count_) return static_cast<std::size_t>(id);
        auto const found = is_plain_ ? index_.end() : index_.find(id);
        sluice::require(found != index_.end(), [&] {
            return sluice::Error("a load on grain " + std::to_string(id) + ", which is none of the " +
                                     std::to_string(count_) + " grains.",
                                 sluice::Exit::protocol);
        });
        return found->second;
    }

 private:
    std::size_t count_;
    bool is_plain_ = true;
    std::unordered_map<std::int64_t, std::size_t> index_;
};

//! Adds the forces that one partner sends to the grains, by id, as they are at a time of the window.
template <int D>
void add_load(sluice::Load const& load, Finder const& find, Grains<D>& g)
{
    for (std::size_t k = 0; k < load.id.size(); ++k) {
        Load<D>& to = g.external[find(load.id[k])];
        if constexpr (D == 2) {
            to.force += Vec2{load.force[2 * k], load.force[2 * k + 1]};
            to.torque += load.torque[k];
        } else {
            to.force += Vec3{load.force[3 * k], load.force[3 * k + 1], load.force[3 * k + 2]};
            to.torque += Vec3{load.torque[3 * k], load.torque[3 * k + 1], load.torque[3 * k + 2]};
        }
    }
}

//! One window in equal steps of our own; the load is sampled in the middle of each. Returns the impulse that it gave to
//! all grains [N s]; discs: per metre.
template <int D>
Vec<D> advance(Solver<D>& solver, double step, sluice::Window const& window, Finder const& find,
               std::vector<sluice::Sampled<sluice::Load>>& loads)
{
    auto const steps = std::max<std::int64_t>(1, static_cast<std::int64_t>(std::ceil(window.length / step - 1e-9)));
    double const dt = window.length / static_cast<double>(steps);
    Vec<D> impulse{};
    for (std::int64_t k = 0; k < steps; ++k) {
        if (!loads.empty()) {
            auto& g = solver.grains();
            std::fill(g.external.begin(), g.external.end(), Load<D>{});
            for (auto& load : loads) add_load(load.at(window.begin + (static_cast<double>(k) + 0.5) * dt), find, g);
            Vec<D> force{};
            for (auto const& external : g.external) force += external.force;
            impulse += dt * force;
        }
        solver.step(dt);
    }
    return impulse;
}

//! What the summary says about the start; a checkpoint keeps it, for the summary of a resumed run.
struct Start
{
    double height = 0, front = 0, mean_diameter = 0;  //!< m
    double packing_fraction = 0;                      //!< 0: not a column, or too narrow to measure it

    void keep(sluice::State& state) const
    {
        state.put("start", std::vector<double>{height, front, mean_diameter, packing_fraction});
    }
    static Start kept(sluice::State const& state)
    {
        auto const numbers = state.numbers("start", 4);
        return {numbers[0], numbers[1], numbers[2], numbers[3]};
    }
};

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

template <int D>
Start start_of(Config const& config, Solver<D> const& solver)
{
    auto const m = measure(solver);
    Start start{m.height, m.front};
    for (auto const& place : solver.grains().place)
        start.mean_diameter += 2 * place.radius / static_cast<double>(solver.grains().size());
    if (!config.column) return start;
    if (auto const core = core_of<D>(*config.column, m, start.mean_diameter))
        start.packing_fraction = packing_fraction<D>(solver.grains(), core->first, core->second);
    return start;
}

void state_facts(sluice::Participant& self, Config const& config, std::size_t grains, Start const& start)
{
    self.fact("grains", static_cast<double>(grains));
    self.fact("H0 [m]", start.height);
    self.fact("L0 [m]", start.front);
    self.fact("mean diameter [m]", start.mean_diameter);
    self.fact("longest step [s]", config.step);
    self.fact("contact time [s]", config.contact_time);
    if (start.packing_fraction > 0) self.fact("packing fraction", start.packing_fraction);
}

std::size_t count_grains(Config const& config)
{
    return static_cast<std::size_t>(config.column ? config.column->count
                                    : config.fill ? config.fill->count
                                                  : 0) +
           config.grains.size();
}

//! At t = 0; in a resumed run without grains: the checkpoint brings them, nothing is poured.
template <int D>
Solver<D> prepare_solver(sluice::Participant& self, Config const& config, Ledger ledger)
{
    if (self.resumes()) return {make_setup<D>(config, ledger), {}};
    auto const packing = prepare_packing<D>(config, packing_cache(), [&](std::string const& line) { self.note(line); });
    return make_solver(config, packing, ledger);
}

//! Whether windows may be computed several times before they stand.
bool iterates(sluice::Participant const& self)
{
    return !self.scene().implicit.empty();
}

void describe(Config const& config)
{
    std::printf("grains: contact time %.4g s, longest step %.4g s\n", config.contact_time, config.step);
    if (config.column)
        std::printf("grains: column of %lld grains, %.4g m wide\n", static_cast<long long>(config.column->count),
                    column_width(config));
    for (auto const& warning : config.warnings) std::printf("grains: warning: %s\n", warning.c_str());
}

template <int D>
void run(sluice::Participant& self, Config const& config)
{
    bool const series = self.scene().series_interval > 0, ledger = series && config.scheme != Scheme::liggghts;
    Solver<D> solver = prepare_solver<D>(self, config, ledger ? Ledger::on : Ledger::off);
    Start start;
    SteadyShear steady;
    bool const sheared = config.periodic.is_sheared();
    self.keeps(
        [&](sluice::State& state) {
            keep(solver.state(), state);
            start.keep(state);
            if (sheared) steady.keep(state);
        },
        [&](sluice::State const& state) {
            solver.restore(kept_state<D>(state, solver.setup(), count_grains(config)));
            start = Start::kept(state);
            if (sheared) steady = SteadyShear::kept(state);
        });
    if (!ledger)
        self.skipped("energy ledger",
                     series ? "scheme: liggghts keeps none" : "no time series is asked for (output.series)", 1.0);
    auto const receivers = self.receivers("kinematics"), senders = self.senders("load");
    if (senders.empty()) self.skipped("fluid", "no participant sends a load: it is not started", 1.0);

    Columns<D> columns;
    std::optional<Recorder<D>> recorder;
    auto tell = [&] {
        columns.update(solver.grains());
        for (auto const& to : receivers) self.write(to, columns.kinematics());
    };
    if (!self.resumes()) {
        start = start_of(config, solver);
        tell();
        recorder.emplace(self, config);
        recorder->picture(0.0, columns);
        recorder->row(0.0, solver, {});
    }
    sluice::Windows windows = self.windows();
    if (self.resumes()) recorder.emplace(self, config, self.resumed_at());
    state_facts(self, config, solver.grains().size(), start);
    Finder const find(solver.grains().id);
    for (sluice::Window const& window : windows) {
        if (self.went_back()) recorder.emplace(self, config, self.resumed_at());
        std::vector<sluice::Sampled<sluice::Load>> loads;
        for (auto const& from : senders) loads.push_back(self.read<sluice::Load>(from, window));
        Vec<D> const impulse = advance(solver, config.step, window, find, loads);
        tell();
        if (iterates(self) && !self.accepted(window)) continue;
        if (sheared) steady.sample(solver);
        if (window.output) recorder->picture(window.end, columns);
        if (window.series) recorder->row(window.end, solver, impulse);
    }
    auto const m = measure(solver);
    self.fact("final run-out [m]", m.front);
    self.fact("final height [m]", m.height);
    if (sheared)
        for (auto const& [name, value] : steady.facts()) self.fact(name, value);
    recorder->close();
}

void take_part(sluice::Participant& self)
{
    self.sends({"kinematics"});
    self.takes({"load"});
    auto const& gravity = self.scene().gravity;
    int const dimension = self.scene().dimension;
    Config config = read_config(self.config(), dimension, {gravity[0], gravity[1], dimension == 3 ? gravity[2] : 0.0});
    for (auto const& warning : config.warnings) self.warn(warning);
    self.propose_window(steps_of_a_dry_window * config.step);
    if (self.checking()) return describe(config);
    config.loads = !self.senders("load").empty();
    sluice::require(!config.loads || !config.periodic.is_sheared(), [] {
        return sluice::Error(
            "a sheared cell of grains takes no load of a partner (the fluid would have to be sheared "
            "with it). Remove the coupling or config.shear.");
    });
    dimension == 2 ? run<2>(self, config) : run<3>(self, config);
}

}  // namespace

int main(int argc, char** argv)
{
    return sluice::run(argc, argv, take_part);
}

}  // namespace dem
