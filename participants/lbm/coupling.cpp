#include "participants/lbm/coupling.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#include "coupler/coupler.hpp"
#include "participants/lbm/recorder.hpp"
#include "participants/lbm/slab_cost.hpp"
#include "participants/lbm/solver.hpp"
#include "participants/ranks/known_to_all.hpp"
#include "participants/ranks/mpi_peers.hpp"
#include "participants/ranks/restart.hpp"

namespace lbm {
namespace {

//! Mean force and torque on each body over the steps of one window: the impulse that the fluid gave, over its length.
template <int D>
struct MeanLoad
{
    std::vector<std::int64_t> id;
    std::vector<double> force, torque;

    void restart(std::span<std::int64_t const> ids)
    {
        id.assign(ids.begin(), ids.end());
        force.assign(D * ids.size(), 0.0);
        torque.assign(spins<D> * ids.size(), 0.0);
    }
    void add(LoadsView const& loads, double share)
    {
        for (std::size_t k = 0; k < force.size(); ++k) force[k] += share * loads.force[k];
        for (std::size_t k = 0; k < torque.size(); ++k) torque[k] += share * loads.torque[k];
    }
    std::array<double, D> impulse(double length) const
    {
        std::array<double, D> sum{};
        for (std::size_t k = 0; k < force.size(); ++k) sum[k % D] += force[k];
        for (double& component : sum) component *= length;
        return sum;
    }
    sluice::Load view() const { return {id, force, torque}; }
};

//! How the work was shared out, summed over the steps of the run; for the summary.
struct Shares
{
    double covered_cells = 0, rebuilt_bodies = 0, without_solid_loads = 0, steps = 0;

    void add(Share const& share, SolidLoads on_solids)
    {
        covered_cells += share.covered_cells;
        rebuilt_bodies += share.rebuilt_bodies;
        without_solid_loads += on_solids == SolidLoads::left_out ? 1 : 0;
        steps += 1;
    }
    void keep(sluice::State& state) const
    {
        state.put("shares", std::vector<double>{covered_cells, rebuilt_bodies, without_solid_loads, steps});
    }
    static Shares kept(sluice::State const& state)
    {
        auto const numbers = state.numbers("shares", 4);
        return {numbers[0], numbers[1], numbers[2], numbers[3]};
    }
};

BodiesView bodies_of(sluice::Kinematics const& k)
{
    // lasting ids are the same bits, signed there and unsigned here
    std::span<std::uint64_t const> const ids(reinterpret_cast<std::uint64_t const*>(k.id.data()), k.id.size());
    return {k.position, k.velocity, k.angular_velocity, k.radius, ids};
}

//! The solver, made anew where it is when its lattice is shared out by another cost of layers. No step is under way.
template <int D>
class SharedSolver
{
 public:
    SharedSolver(Config const& config, ranks::Peers* peers) : config_(config), peers_(peers)
    {
        solver_.emplace(config, peers);
    }
    Solver<D>& solver() noexcept { return *solver_; }
    void share_out(std::vector<double> const& extra)
    {
        if (extra == extra_) return;
        extra_ = extra;
        solver_.emplace(config_, peers_, extra);
    }

 private:
    Config const& config_;
    ranks::Peers* peers_;
    std::vector<double> extra_{};
    std::optional<Solver<D>> solver_{};
};

//! Solids finer than a cell: where they are at the start of a window, and the mean force on them in it.
template <int D>
class PhaseEdge
{
 public:
    PhaseEdge(sluice::Participant& self, ranks::Peers* peers)
        : self_(self), receivers_(self.receivers("body_force")), from_(self.sender("phase")), known_(peers)
    {}
    bool exists() const { return !from_.empty(); }

    void begin(sluice::Window const& window, std::int64_t steps, Solver<D>& solver)
    {
        auto sampled = self_.read<sluice::SolidPhase>(from_, window);
        auto const points = known_.share(sampled.at(window.begin));
        id_.assign(points.id.begin(), points.id.end());
        solver.set_phase({points.id, points.position, points.velocity, points.solid_volume}, steps);
    }
    void tell(Solver<D>& solver)
    {
        for (auto const& to : receivers_)
            self_.write(to, self_.rank() == 0 ? sluice::BodyForce{id_, solver.phase_force()} : sluice::BodyForce{});
    }

 private:
    sluice::Participant& self_;
    std::vector<std::string> receivers_;
    std::string from_;
    ranks::KnownToAll<sluice::SolidPhase> known_;
    std::vector<std::int64_t> id_;
};

//! The drag is implicit: it belongs to the window that it is reckoned for.
void require_drag_at_once(sluice::Participant const& self)
{
    auto const& scene = self.scene();
    for (auto const& edge : scene.edges)
        sluice::require(edge.from != scene.index_of(self.name()) || edge.lag == 0 ||
                            scene.data[static_cast<std::size_t>(edge.data)].name != "body_force",
                        [&] {
                            return sluice::Error("lbm: " + edge.path +
                                                 " = body_force with lag: " + std::to_string(edge.lag) +
                                                 " (needed: lag: 0, the drag is that of the window). Try lag: 1 on the "
                                                 "edge with data: phase instead.");
                        });
}

Config read(sluice::Participant& self)
{
    self.sends({"load", "body_force"});
    self.takes({"kinematics", "phase"});
    bool const phase = !self.senders("phase").empty();
    for (auto const& to : self.receivers("body_force"))
        sluice::require(phase, [&] {
            return sluice::Error("lbm: body_force to " + to +
                                 ", but nobody sends a phase (it acts on the points of one). Add an edge {from: " + to +
                                 ", to: " + self.name() + ", data: phase, lag: 1}.");
        });
    require_drag_at_once(self);
    auto reader = self.config();
    auto const* rotation = self.rotation();
    return read_config(reader, self.scene().dimension, self.scene().gravity,
                       rotation ? std::optional(*rotation) : std::nullopt, phase, self.ranks());
}

void tell_of_what_is_stored(sluice::Participant& self, Config const& config, Layout const& layout)
{
    self.fact("cells", static_cast<double>(config.cells()[0] * config.cells()[1] * config.cells()[2]));
    if (layout.whole()) return;
    self.fact("cells that are stored", static_cast<double>(layout.stored()));
    if (self.rank() == 0)
        self.note(std::to_string(layout.stored()) +
                  " cells hold fluid or are near it; the others, deep in solids at rest, are not stored");
}

//! What a run leaves behind. All processes make the same calls; the first writes.
template <int D>
class Recording
{
 public:
    Recording(sluice::Participant& self, Config const& config, Solver<D>& solver)
        : self_(self), config_(config), solver_(solver), coarsen_(self.scene().coarsen)
    {}

    void begin(std::optional<double> resumed_at)
    {
        if (self_.rank() > 0) return;
        recorder_.emplace(sluice::RunNames{self_.directory(), self_.name(), self_.scene().hash}, config_, coarsen_,
                          resumed_at);
        if (auto const remark = recorder_->remark(); !remark.empty()) self_.warn(remark);
    }
    void picture(double time)
    {
        auto const fields = solver_.fields(coarsen_, config_.output.fields);
        if (recorder_) recorder_->picture(time, fields);
    }
    void row(double time, std::array<double, D> const& impulse, std::vector<double> const& on_solids)
    {
        auto const now = measured<D>(solver_, impulse, on_solids);
        if (recorder_) recorder_->row(time, now);
    }
    void close()
    {
        if (recorder_) recorder_->close();
    }

 private:
    sluice::Participant& self_;
    Config const& config_;
    Solver<D>& solver_;
    int coarsen_;
    std::optional<Recorder<D>> recorder_;
};

void tell_at_start(sluice::Participant& self, Config const& config, Layout const& layout)
{
    tell_of_what_is_stored(self, config, layout);
    self.fact("time step [s]", config.step);
    self.fact("relaxation time", config.relaxation_time());
    if (config.phase) self.fact("bulk modulus of the fluid [Pa]", config.units().pressure_unit() / 3);
}

//! Whether the table may get a row at the end of the next window. Its first step's loads take in the step before.
bool row_may_follow(sluice::Window const& window, sluice::Scene const& scene)
{
    if (scene.participants.size() > 1) return true;  // who paces the run may make windows longer, or end it
    sluice::Window next{.begin = window.end, .end = window.end + 1.001 * window.length};  // more than it will be
    next.last = next.end >= scene.end;
    return next.due(scene.series_interval);
}

void tell_what_was_skipped(sluice::Participant& self, Config const& config, Shares const& shares, ranks::Peers* peers)
{
    double const covered =
        peers ? ranks::sums(*peers, std::vector<double>{shares.covered_cells})[0] : shares.covered_cells;
    self.skipped("grain kernel", "cells that no grain covers run the plain fluid kernel", 1 - covered / shares.steps);
    self.skipped("solid fractions", "grains that moved too little keep those of the step before",
                 1 - shares.rebuilt_bodies / shares.steps);
    if (!config.solids.empty())
        self.skipped("loads on solids at rest", "steps of windows after which no row of the table is written",
                     shares.without_solid_loads / shares.steps);
}

//! Of several processes, all of which call it, the first speaks with partners.
template <int D>
void run(sluice::Participant& self, Config const& config)
{
    bool const first = self.rank() == 0;
    auto const peers = self.ranks() > 1 ? ranks::mpi_peers(self.rank(), self.ranks()) : nullptr;
    SharedSolver<D> shared(config, peers.get());
    Solver<D>& solver = shared.solver();
    Shares shares;
    self.keeps(
        [&](sluice::State& state) {
            solver.keep(state);
            shares.keep(state);
        },
        [&](sluice::State const& state) {
            shared.share_out(extra_of(state));
            solver.restore(state);
            shares = Shares::kept(state);
        });
    Recording<D> recording(self, config, solver);
    if (!self.resumes()) recording.begin(std::nullopt);
    tell_at_start(self, config, solver.layout());
    auto const sender = self.sender("kinematics");
    auto const receivers = self.receivers("load");

    PhaseEdge<D> phase(self, peers.get());
    ranks::KnownToAll<sluice::Kinematics> known(peers.get());
    MeanLoad<D> load;
    std::vector<double> on_solids(D * config.solids.size());  // mean force of a window
    auto tell = [&] {
        for (auto const& to : receivers) self.write(to, first ? load.view() : sluice::Load{});
        if (phase.exists()) phase.tell(solver);
    };
    if (!self.resumes()) tell();
    sluice::Windows windows = self.windows();
    if (self.resumes()) recording.begin(self.resumed_at());
    bool const iterates = !self.scene().implicit.empty();  // windows may be computed several times before they stand
    for (sluice::Window const& window : windows) {
        if (self.went_back()) recording.begin(self.resumed_at());
        auto const steps = static_cast<std::int64_t>(std::lround(window.length / config.step));
        if (config.lightest_grain > 0 && steps > 1 && window.index == 0)
            self.warn("lightest_grain: windows of " + std::to_string(steps) +
                      " steps of the fluid (it is known for one). Try time.window: auto.");
        if (phase.exists()) phase.begin(window, steps, solver);
        for (std::int64_t k = 0; k < steps; ++k) {
            if (!sender.empty()) {
                auto kinematics = self.read<sluice::Kinematics>(sender, window);
                auto const bodies =
                    known.share(kinematics.at(window.begin + (static_cast<double>(k) + 0.5) * config.step));
                if (k == 0) load.restart(bodies.id);
                bool const fresh = k == 0 && window.index == 0 && !iterates && !phase.exists();
                if (fresh && peers) shared.share_out(cost_of_bodies<D>(config, bodies_of(bodies)));
                solver.set_bodies(bodies_of(bodies));
            }
            if (k == 0 && window.index == 0 && window.iteration == 0) {
                recording.picture(0.0);
                recording.row(0.0, {}, on_solids);
            }
            auto const asked = window.series || (k + 1 == steps && row_may_follow(window, self.scene()))
                                   ? SolidLoads::found
                                   : SolidLoads::left_out;
            solver.step(asked);
            if (k == 0) std::fill(on_solids.begin(), on_solids.end(), 0.0);
            for (std::size_t i = 0; i < on_solids.size(); ++i)  // counts where a row follows: found in all steps there
                on_solids[i] += solver.solid_loads().force[i] / static_cast<double>(steps);
            load.add(solver.loads(), 1.0 / static_cast<double>(steps));
            shares.add(solver.share(), asked);
        }
        tell();
        if (iterates && !self.accepted(window)) continue;
        if (window.output) recording.picture(window.end);
        if (window.series) recording.row(window.end, load.impulse(window.length), on_solids);
    }
    tell_what_was_skipped(self, config, shares, peers.get());
    recording.close();
}

void take_part(sluice::Participant& self)
{
    Config const config = read(self);
    require_shareable(config, self.ranks());
    ranks::refuse_restart(self.scene(), self.name());
    for (auto const& line : describe(config))
        if (self.checking()) std::printf("fluid: %s\n", line.c_str());
    for (auto const& issue : find_issues(config)) {
        if (self.checking()) std::printf("fluid: warning: %s: %s\n", issue.key.c_str(), issue.text.c_str());
        if (self.rank() == 0) self.warn(issue.key + ": " + issue.text);
    }
    if (self.rank() > 0) self.covers({{1, 1, 1}, {-1, -1, -1}});  // nothing: the first process hears for all
    self.propose_window(config.step, true);
    if (self.checking()) return;
    if (config.dimension == 2)
        run<2>(self, config);
    else
        run<3>(self, config);
}

}  // namespace

int main(int argc, char** argv)
{
    return sluice::run(argc, argv, take_part);
}

}  // namespace lbm
