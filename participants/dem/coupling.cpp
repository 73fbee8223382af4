#include "participants/dem/coupling.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>
#include <utility>

#include "coupler/coupler.hpp"
#include "participants/dem/checkpoint.hpp"
#include "participants/dem/domain.hpp"
#include "participants/dem/measures.hpp"
#include "participants/dem/partner_loads.hpp"
#include "participants/dem/recorder.hpp"
#include "participants/dem/setup.hpp"
#include "participants/dem/start.hpp"
#include "participants/dem/steady_shear.hpp"
#include "participants/ranks/mpi_peers.hpp"
#include "participants/ranks/restart.hpp"

namespace dem {
namespace {

constexpr double steps_of_a_dry_window = 50;  // without a partner a window only paces the output

template <int D>
sluice::Kinematics kinematics_of(Columns<D> const& c)
{
    return {c.id, c.position, c.velocity, c.spin, c.radius};
}

//! The same for a fluid that does not resolve them.
template <int D>
void tell_phase(sluice::Participant& self, std::vector<std::string> const& receivers, Columns<D> const& c,
                std::vector<double>& volume)
{
    if (receivers.empty()) return;
    volume.clear();
    for (double const radius : c.radius) volume.push_back(volume_of<D>(radius));
    for (auto const& to : receivers) self.write(to, sluice::SolidPhase{c.id, c.position, c.velocity, volume});
}

//! What partners do to the grains in a window.
class PartnerSamples
{
 public:
    PartnerSamples(sluice::Participant& self, sluice::Window const& window)
    {
        for (auto const& from : self.senders("load")) loads_.push_back(self.read<sluice::Load>(from, window));
        for (auto const& from : self.senders("body_force"))
            forces_.push_back(self.read<sluice::BodyForce>(from, window));
    }
    bool any() const { return !loads_.empty() || !forces_.empty(); }
    bool vary() const
    {
        auto const varies = [](auto const& sample) { return sample.vary(); };
        return std::ranges::any_of(loads_, varies) || std::ranges::any_of(forces_, varies);
    }
    std::vector<PartnerLoad> at(double time)
    {
        std::vector<PartnerLoad> parts;
        for (auto& sample : loads_) {
            auto const load = sample.at(time);
            parts.push_back({load.id, load.force, load.torque});
        }
        for (auto& sample : forces_) {
            auto const force = sample.at(time);
            parts.push_back({force.id, force.force, {}});
        }
        return parts;
    }

 private:
    std::vector<sluice::Sampled<sluice::Load>> loads_;
    std::vector<sluice::Sampled<sluice::BodyForce>> forces_;
};

//! One window in equal steps of our own; what partners do is sampled in the middle of each, or once if it stays the
//! same. Returns the impulse that it gave to all grains [N s]; discs: per metre. Of several processes the first one's
//! samples have all points, the others' none.
template <int D>
Vec<D> advance(Solver<D>& solver, double step, sluice::Window const& window, PartnerLoads<D>& loads,
               PartnerSamples& samples)
{
    std::int64_t const steps = window.steps(step);
    double const dt = window.length / static_cast<double>(steps);
    bool const vary = samples.vary();
    Vec<D> impulse{};
    for (std::int64_t k = 0; k < steps; ++k) {
        if (samples.any() && (k == 0 || vary)) {
            loads.take(samples.at(window.begin + (static_cast<double>(k) + 0.5) * dt));
            solver.set_loads(loads.on_grains());
        }
        impulse += dt * loads.force();
        if (vary) solver.step(dt);
    }
    if (!vary) solver.steps(dt, steps);
    return impulse;
}

//! At t = 0; in a resumed run without grains: the checkpoint brings them, nothing is poured. Without grains, too, on
//! all processes but the first.
template <int D>
Solver<D> prepare_solver(sluice::Participant& self, Config const& config, Ledger ledger)
{
    if (self.resumes() || self.rank() > 0) return {make_setup<D>(config, ledger), {}};
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
    if (!config.grains_from.empty())
        std::printf("grains: %zu of %s\n", config.grains.size(), config.grains_from.c_str());
    if (config.column)
        std::printf("grains: column of %lld grains, %.4g m wide\n", static_cast<long long>(config.column->count),
                    column_width(config));
    for (auto const& warning : config.warnings) std::printf("grains: warning: %s\n", warning.c_str());
}

//! Why the ledger of energies is off.
std::string why_no_ledger(Config const& config, bool series)
{
    if (config.scheme == Scheme::liggghts && series) return "scheme: liggghts keeps none";
    return config.measures.stated ? "no measure needs it (energies, drift)"
                                  : "no time series is asked for (output.series)";
}

Due due_at(sluice::Window const& window)
{
    return {window.end, window.output, window.series, [&window](double interval) { return window.due(interval); }};
}
Due const at_start{0.0, true, true, [](double) { return true; }};

//! All grains of a run, whether one process has them or several; then the first sees them, the others see none.
template <int D>
class Overview
{
 public:
    explicit Overview(Solver<D> const& solver) : solver_(solver) {}

    //! As they are now. Called by all processes.
    Solver<D> const& now()
    {
        if (!solver_.domain()) return solver_;
        if (!all_) all_.emplace(solver_.setup(), Grains<D>{});
        all_->restore(solver_.whole());
        return *all_;
    }
    //! As they were when now() was called last.
    Solver<D> const& last() const { return solver_.domain() ? *all_ : solver_; }
    //! Where they are now and how they move; nothing else is up to date. After now(), by all processes.
    Grains<D> const& in_motion()
    {
        if (!solver_.domain()) return solver_.grains();
        solver_.gather_motion(all_->grains());
        return all_->grains();
    }

 private:
    Solver<D> const& solver_;
    std::optional<Solver<D>> all_;
};

//! Several processes: the grains of the first are shared out.
template <int D>
void share_out(sluice::Participant& self, Solver<D>& solver, ranks::Peers* peers)
{
    if (!peers) return;
    solver.share_out(*peers);
    auto const& ghost = solver.grains().ghost;
    auto const seen = static_cast<std::size_t>(std::count(ghost.begin(), ghost.end(), std::uint8_t{1}));
    if (2 * seen > ghost.size())
        self.warn("process " + std::to_string(self.rank()) + " of the grains has " +
                  std::to_string(ghost.size() - seen) + " of its own and sees " + std::to_string(seen) +
                  " of others: its part is too thin to be worth a process. Try fewer ranks.");
}

template <int D>
void run(sluice::Participant& self, Config const& config)
{
    bool const first = self.rank() == 0;
    auto const peers = self.ranks() > 1 ? ranks::mpi_peers(self.rank(), self.ranks()) : nullptr;
    double const series = self.scene().series_interval;
    bool const ledger = config.measures.need_ledger(series) && config.scheme != Scheme::liggghts;
    Solver<D> solver = prepare_solver<D>(self, config, ledger ? Ledger::on : Ledger::off);
    Start start;
    Overview<D> overview(solver);
    SteadyShear steady;
    bool const sheared = config.periodic.is_sheared();
    self.keeps(
        [&](sluice::State& state) {
            keep(overview.now().state(), state);
            keep_source(config, state);
            start.keep(state);
            if (sheared) steady.keep(state);
        },
        [&](sluice::State const& state) {
            require_source(config, state);
            solver.restore(kept_state<D>(state, solver.setup(), first ? count_grains(config) : 0));
            start = Start::kept(state);
            if (sheared) steady = SteadyShear::kept(state);
        });
    if (!ledger) self.skipped("energy ledger", why_no_ledger(config, series > 0), 1.0);
    auto const receivers = self.receivers("kinematics"), unresolved = self.receivers("phase");
    if (!config.loads) self.skipped("fluid", "no participant sends a load: it is not started", 1.0);

    Columns<D> columns;
    std::vector<double> volume;
    std::optional<Recorder<D>> recorder;
    auto begin_recording = [&](std::optional<double> resumed_at) {
        if (!first) return;
        recorder.emplace(sluice::RunNames{self.directory(), self.name(), self.scene().hash}, config,
                         start.mean_diameter, resumed_at);
        if (auto const remark = recorder->remark(); !remark.empty()) self.warn(remark);
    };
    auto tell = [&](Grains<D> const& all) {
        columns.update(all);
        for (auto const& to : receivers) self.write(to, kinematics_of(columns));
        tell_phase(self, unresolved, columns, volume);
    };
    if (!self.resumes()) tell(solver.grains());
    if (!self.resumes() && first) {
        start = start_of(config, solver);
        begin_recording(std::nullopt);
        recorder->record(at_start, columns, {solver, {}, start.balance});
    }
    share_out(self, solver, peers.get());
    sluice::Windows windows = self.windows();
    if (self.resumes()) begin_recording(self.resumed_at());
    for (auto const& [name, value] : facts_of(config, start)) self.fact(name, value);
    PartnerLoads<D> loads(overview.now().grains().id);
    for (sluice::Window const& window : windows) {
        if (self.went_back()) begin_recording(self.resumed_at());
        PartnerSamples samples(self, window);
        Vec<D> const impulse = advance(solver, config.step, window, loads, samples);
        Due const due = due_at(window);
        bool const looked_at = is_anything_due(config.measures, due);  // else more would be gathered than is told
        if (looked_at)
            tell(overview.now().grains());
        else if (!receivers.empty() || !unresolved.empty())
            tell(overview.in_motion());
        if (iterates(self) && !self.accepted(window)) continue;
        if (sheared) steady.sample(solver);
        if (first && looked_at) recorder->record(due, columns, {overview.last(), impulse, start.balance});
    }
    auto const& all = overview.now();
    if (!first) return;
    auto const m = measure(all);
    self.fact("final run-out [m]", m.front);
    self.fact("final height [m]", m.height);
    if (sheared)
        for (auto const& [name, value] : steady.facts()) self.fact(name, value);
    recorder->close();
}

//! What several processes cannot do.
void check_ranks(sluice::Participant const& self, Config const& config)
{
    if (self.ranks() == 1) return;
    config.dimension == 2 ? require_shareable(make_setup<2>(config)) : require_shareable(make_setup<3>(config));
    ranks::refuse_restart(self.scene(), self.name());
}

void take_part(sluice::Participant& self)
{
    self.sends({"kinematics", "phase"});
    self.takes({"load", "body_force"});
    auto const& gravity = self.scene().gravity;
    int const dimension = self.scene().dimension;
    auto const* rotation = self.rotation();
    Config config = read_config(self.config(), dimension, {gravity[0], gravity[1], gravity[2]},
                                rotation ? std::optional(*rotation) : std::nullopt);
    if (self.rank() == 0)
        for (auto const& warning : config.warnings) self.warn(warning);
    check_ranks(self, config);
    if (self.rank() > 0) self.covers({{1, 1, 1}, {-1, -1, -1}});  // nothing: the first process speaks for all
    self.propose_window(steps_of_a_dry_window * config.step);
    if (self.checking()) return describe(config);
    config.loads = !self.senders("load").empty() || !self.senders("body_force").empty();
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
