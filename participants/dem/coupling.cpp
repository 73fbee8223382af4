#include "participants/dem/coupling.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numeric>
#include <optional>

#include "coupler/coupler.hpp"
#include "coupler/record/archive.hpp"
#include "coupler/record/point_series.hpp"
#include "coupler/record/table.hpp"
#include "participants/dem/checkpoint.hpp"
#include "participants/dem/measures.hpp"
#include "participants/dem/setup.hpp"

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

//! The grains as columns for frames, files and archives: interleaved, as all of those want them.
struct Columns
{
    std::vector<std::int64_t> id;
    std::vector<double> position, velocity, radius, force;

    void update(Grains const& g)
    {
        auto const n = g.size();
        id.resize(n);
        position.resize(2 * n);
        velocity.resize(2 * n);
        force.resize(2 * n);
        radius = g.radius;
        for (std::size_t i = 0; i < n; ++i) {
            id[i] = static_cast<std::int64_t>(i);
            position[2 * i] = g.x[i];
            position[2 * i + 1] = g.y[i];
            velocity[2 * i] = g.vx[i];
            velocity[2 * i + 1] = g.vy[i];
            force[2 * i] = g.external_fx[i];
            force[2 * i + 1] = g.external_fy[i];
        }
    }
    sluice::Kinematics kinematics(Grains const& g) const { return {id, position, velocity, g.spin, radius}; }
};

//! What a run leaves behind: ParaView series, HDF5 archive, time series. A resumed run goes on with what is there up to
//! `resumed_at` [s].
class Recorder
{
 public:
    explicit Recorder(sluice::Participant& self, std::optional<double> resumed_at = std::nullopt)
        : series_(self.directory(), self.name(), sluice::Precision::float32, resumed_at),
          archive_(self.directory() / (self.name() + ".h5"),
                   std::vector<sluice::ArchiveFact>{{"scene_hash", std::to_string(self.scene().hash)}}, resumed_at),
          table_(self.directory() / (self.name() + ".csv"), headers(), resumed_at)
    {
        if (auto const remark = archive_.remark(series_.frames()); !remark.empty()) self.warn(remark);
    }

    void picture(double time, Columns const& c, Grains const& g)
    {
        std::vector<double> diameter(c.radius);
        for (double& d : diameter) d *= 2;
        series_.append(time, c.id,
                       std::vector<sluice::PointColumn>{{"position", "m", 2, c.position},
                                                        {"velocity", "m/s", 2, c.velocity},
                                                        {"angular_velocity", "rad/s", 1, g.spin},
                                                        {"radius", "m", 1, c.radius},
                                                        {"diameter", "m", 1, diameter},
                                                        {"fluid_force", "N/m", 2, c.force}});
        auto const n = g.size();
        archive_.append(time, std::vector<sluice::ArchiveDataset>{{"id", "", std::span<std::int64_t const>(c.id), {n}},
                                                                  {"position", "m", std::span(c.position), {n, 2}},
                                                                  {"velocity", "m/s", std::span(c.velocity), {n, 2}},
                                                                  {"angular_velocity", "rad/s", std::span(g.spin), {n}},
                                                                  {"radius", "m", std::span(c.radius), {n}},
                                                                  {"fluid_force", "N/m", std::span(c.force), {n, 2}}});
    }

    void row(double time, Solver const& solver, Vec2 impulse)
    {
        auto const m = measure(solver);
        auto const e = solver.energies();
        table_.append(std::vector<double>{time,
                                          m.front,
                                          m.foremost,
                                          m.height,
                                          e.kinetic_linear,
                                          e.kinetic_rotational,
                                          e.potential,
                                          e.elastic_normal + e.elastic_tangential,
                                          e.normal_dashpot,
                                          e.tangential_dashpot,
                                          e.sliding,
                                          e.removed_walls + e.touch,
                                          e.external_work,
                                          e.balance(),
                                          m.centre_of_mass.x,
                                          m.centre_of_mass.y,
                                          m.coordination,
                                          static_cast<double>(m.contacts),
                                          m.largest_overlap,
                                          impulse.x,
                                          impulse.y});
    }

    void close() { archive_.close(); }

 private:
    static std::vector<std::string> headers()
    {
        return {"time [s]",
                "run_out [m]",
                "foremost [m]",
                "height [m]",
                "kinetic [J/m]",
                "rotational [J/m]",
                "potential [J/m]",
                "elastic [J/m]",
                "dissipated_normal [J/m]",
                "dissipated_tangential [J/m]",
                "dissipated_sliding [J/m]",
                "vanished [J/m]",
                "fluid_work [J/m]",
                "balance [J/m]",
                "centre_x [m]",
                "centre_y [m]",
                "coordination",
                "contacts",
                "largest_overlap",
                "window_impulse_x [N s/m]",  // that the fluid gave in the last window
                "window_impulse_y [N s/m]"};
    }

    sluice::PointSeries series_;
    sluice::Archive archive_;
    sluice::Table table_;
};

//! Adds the forces that one partner sends to the grains, by id, as they are at a time of the window.
void add_load(sluice::Load const& load, Grains& g)
{
    for (std::size_t k = 0; k < load.id.size(); ++k) {
        auto const i = static_cast<std::size_t>(load.id[k]);
        sluice::require(i < g.size(), [&] {
            return sluice::Error("a load on grain " + std::to_string(load.id[k]) + ", but there are " +
                                     std::to_string(g.size()) + " grains.",
                                 sluice::Exit::protocol);
        });
        g.external_fx[i] += load.force[2 * k];
        g.external_fy[i] += load.force[2 * k + 1];
        g.external_torque[i] += load.torque[k];
    }
}

//! One window in equal steps of our own; the load is sampled in the middle of each. Returns the impulse that it gave to
//! all grains [N s/m].
Vec2 advance(Solver& solver, double step, sluice::Window const& window,
             std::vector<sluice::Sampled<sluice::Load>>& loads)
{
    auto const steps = std::max<std::int64_t>(1, static_cast<std::int64_t>(std::ceil(window.length / step - 1e-9)));
    double const dt = window.length / static_cast<double>(steps);
    Vec2 impulse{};
    for (std::int64_t k = 0; k < steps; ++k) {
        if (!loads.empty()) {
            auto& g = solver.grains();
            std::fill(g.external_fx.begin(), g.external_fx.end(), 0.0);
            std::fill(g.external_fy.begin(), g.external_fy.end(), 0.0);
            std::fill(g.external_torque.begin(), g.external_torque.end(), 0.0);
            for (auto& load : loads) add_load(load.at(window.begin + (static_cast<double>(k) + 0.5) * dt), g);
            impulse.x += dt * std::accumulate(g.external_fx.begin(), g.external_fx.end(), 0.0);
            impulse.y += dt * std::accumulate(g.external_fy.begin(), g.external_fy.end(), 0.0);
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

Start start_of(Config const& config, Solver const& solver)
{
    auto const m = measure(solver);
    Start start{m.height, m.front};
    for (double r : solver.grains().radius) start.mean_diameter += 2 * r / static_cast<double>(solver.grains().size());
    double const mean = start.mean_diameter;
    if (config.column && m.front > 4 * mean)
        start.packing_fraction = packing_fraction(solver.grains(), {mean, mean}, {m.front - mean, m.height - 2 * mean});
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
    return (config.column ? static_cast<std::size_t>(config.column->count) : 0) + config.grains.size();
}

//! At t = 0; in a resumed run without grains: the checkpoint brings them, nothing is poured.
Solver prepare_solver(sluice::Participant& self, Config const& config, Ledger ledger)
{
    if (self.resumes()) return {make_setup(config, ledger), {}};
    auto const packing = prepare_packing(config, packing_cache(), [&](std::string const& line) { self.note(line); });
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

void take_part(sluice::Participant& self)
{
    self.sends({"kinematics"});
    self.takes({"load"});
    sluice::require(self.scene().dimension == 2, [] {
        return sluice::Error("dem: dimension = 3 (this solver is for discs; needed: dimension: 2).");
    });
    auto const& gravity = self.scene().gravity;
    Config const config = read_config(self.config(), {gravity[0], gravity[1]});
    for (auto const& warning : config.warnings) self.warn(warning);
    self.propose_window(steps_of_a_dry_window * config.step);
    if (self.checking()) return describe(config);

    bool const ledger = self.scene().series_interval > 0;
    Solver solver = prepare_solver(self, config, ledger ? Ledger::on : Ledger::off);
    Start start;
    self.keeps(
        [&](sluice::State& state) {
            keep(solver.state(), state);
            start.keep(state);
        },
        [&](sluice::State const& state) {
            solver.restore(kept_state(state, solver.setup(), count_grains(config)));
            start = Start::kept(state);
        });
    if (!ledger) self.skipped("energy ledger", "no time series is asked for (output.series)", 1.0);
    auto const receivers = self.receivers("kinematics"), senders = self.senders("load");
    if (senders.empty()) self.skipped("fluid", "no participant sends a load: it is not started", 1.0);

    Columns columns;
    std::optional<Recorder> recorder;
    auto tell = [&] {
        columns.update(solver.grains());
        for (auto const& to : receivers) self.write(to, columns.kinematics(solver.grains()));
    };
    if (!self.resumes()) {
        start = start_of(config, solver);
        tell();
        recorder.emplace(self);
        recorder->picture(0.0, columns, solver.grains());
        recorder->row(0.0, solver, {});
    }
    sluice::Windows windows = self.windows();
    if (self.resumes()) recorder.emplace(self, self.resumed_at());
    state_facts(self, config, solver.grains().size(), start);
    for (sluice::Window const& window : windows) {
        if (self.went_back()) recorder.emplace(self, self.resumed_at());
        std::vector<sluice::Sampled<sluice::Load>> loads;
        for (auto const& from : senders) loads.push_back(self.read<sluice::Load>(from, window));
        Vec2 const impulse = advance(solver, config.step, window, loads);
        tell();
        if (iterates(self) && !self.accepted(window)) continue;
        if (window.output) recorder->picture(window.end, columns, solver.grains());
        if (window.series) recorder->row(window.end, solver, impulse);
    }
    auto const m = measure(solver);
    self.fact("final run-out [m]", m.front);
    self.fact("final height [m]", m.height);
    recorder->close();
}

}  // namespace

int main(int argc, char** argv)
{
    return sluice::run(argc, argv, take_part);
}

}  // namespace dem
