#include "participants/mpm/coupling.hpp"

#include <cmath>
#include <cstdio>
#include <optional>

#include "coupler/coupler.hpp"
#include "participants/mpm/checkpoint.hpp"
#include "participants/mpm/measures.hpp"
#include "participants/mpm/recorder.hpp"
#include "participants/mpm/setup.hpp"
#include "participants/ranks/known_to_all.hpp"
#include "participants/ranks/mpi_peers.hpp"
#include "participants/ranks/restart.hpp"

namespace mpm {
namespace {

constexpr double front_share = 0.05;      // of the root of the area at the start: 2 to 3 grains, if it has 3000
constexpr double steps_of_a_window = 50;  // without a partner a window only paces the output
constexpr double share_of_a_step = 0.8;   // with grains: a window stays one step if speeds grow by a quarter
constexpr double few_cells = 4;           // of a grain's radius: fewer are warned of (README.md, M13)

//! The grains of a partner, as the edge samples them, and what they got in a window. The first process speaks with the
//! partner; all know the grains.
template <int D>
class GrainEdge
{
 public:
    GrainEdge(sluice::Participant& self, double cell, ranks::Peers* peers)
        : self_(self), cell_(cell), from_(self.sender("kinematics")), known_(peers)
    {}
    bool exists() const { return !from_.empty(); }

    void begin(sluice::Window const& window)
    {
        samples_.emplace(self_.read<sluice::Kinematics>(from_, window));
        auto const ids = samples_->ids();
        id_.assign(ids.begin(), ids.end());
        force_.assign(D * id_.size(), 0.0);
        torque_.assign(spins * id_.size(), 0.0);
    }
    //! As at the start of a step of `dt` that ends at `time`. Points and grid move by velocities of its end: so do
    //! grains.
    std::vector<Grain<D>> grains(double time, double dt)
    {
        auto const k = known_.share(samples_->at(time));
        std::vector<Grain<D>> grains(k.id.size());
        for (std::size_t i = 0; i < grains.size(); ++i) {
            Grain<D>& g = grains[i];
            g.id = k.id[i];
            g.radius = k.radius[i];
            g.velocity = Eigen::Map<Vec<D> const>(k.velocity.data() + D * i);
            g.spin = Eigen::Map<Spin<D> const>(k.angular_velocity.data() + spins * i);
            g.place = Eigen::Map<Vec<D> const>(k.position.data() + D * i) - 0.5 * dt * g.velocity;
            check_size(g);
        }
        return grains;
    }
    //! Of one step of a window: its share of the mean load.
    void add(std::vector<Push<D>> const& pushes, double window)
    {
        for (std::size_t i = 0; i < id_.size(); ++i) {
            for (std::size_t k = 0; k < D; ++k) force_[D * i + k] += pushes[i].impulse[static_cast<int>(k)] / window;
            for (std::size_t k = 0; k < spins; ++k)
                torque_[spins * i + k] += pushes[i].angular[static_cast<int>(k)] / window;
        }
    }
    void tell()
    {
        for (auto const& to : self_.receivers("load")) self_.write(to, sluice::Load{id_, force_, torque_});
    }
    //! What all grains got in a window [N s].
    Vec<D> impulse(double window) const
    {
        Vec<D> sum = Vec<D>::Zero();
        for (std::size_t i = 0; i < force_.size(); ++i) sum[static_cast<int>(i % D)] += window * force_[i];
        return sum;
    }

 private:
    static constexpr std::size_t spins = D == 2 ? 1 : 3;

    void check_size(Grain<D> const& g)
    {
        double const cells = g.radius / cell_;
        if (cells >= few_cells || warned_ || self_.rank() > 0) return;
        warned_ = true;
        char text[200];
        std::snprintf(text, sizeof text,
                      "grain %lld has a radius of %g m, %.3g cells (should be %g or more: friction and the way around "
                      "it are off). Try a finer cell.",
                      static_cast<long long>(g.id), g.radius, cells, few_cells);
        self_.warn(text);
    }

    sluice::Participant& self_;
    double cell_;
    std::string from_;
    std::optional<sluice::Sampled<sluice::Kinematics>> samples_;
    ranks::KnownToAll<sluice::Kinematics> known_;
    std::vector<std::int64_t> id_;  //!< of the first process; others are told of none
    std::vector<double> force_, torque_;
    bool warned_ = false;
};

//! The fluid in the pores: it is told where the matter is, and its force acts on the points.
template <int D>
class FluidEdge
{
 public:
    FluidEdge(sluice::Participant& self, std::optional<FluidConfig> const& fluid, ranks::Peers* peers)
        : self_(self), from_(self.sender("body_force")), known_(peers)
    {
        if (fluid) solid_ = 1 - fluid->porosity;
    }
    bool exists() const { return !from_.empty(); }

    void begin(sluice::Window const& window) { samples_.emplace(self_.read<sluice::BodyForce>(from_, window)); }
    //! At a time of the window, for the points of the run. A point that the fluid does not know feels nothing.
    std::vector<Vec<D>> loads(double time, std::size_t points)
    {
        auto const sample = known_.share(samples_->at(time));
        std::vector<Vec<D>> loads(points, Vec<D>::Zero());
        force_.setZero();
        for (std::size_t i = 0; i < sample.id.size(); ++i) {
            auto const id = static_cast<std::size_t>(sample.id[i]);  // ids count the points of the run
            sluice::require(id < points, [&] {
                return sluice::Error("mpm: a force on point " + std::to_string(sample.id[i]) + ", which is none of " +
                                         std::to_string(points) + ".",
                                     sluice::Exit::protocol);
            });
            loads[id] = Eigen::Map<Vec<D> const>(sample.force.data() + D * i);
            force_ += loads[id];
        }
        return loads;
    }
    Vec<D> const& force() const { return force_; }  //!< on all points, of the last loads() [N]

    //! Called by all processes.
    void tell(Solver<D> const& solver)
    {
        auto const to = self_.receivers("phase");
        if (to.empty()) return;
        auto const& state = solver.in_motion();
        id_.clear(), position_.clear(), velocity_.clear(), volume_.clear();
        auto const all = std::span(state.points).first(self_.rank() == 0 ? state.points.size() : 0);
        for (Point<D> const& p : all) {
            id_.push_back(p.id);
            position_.insert(position_.end(), p.place.data(), p.place.data() + D);
            velocity_.insert(velocity_.end(), p.velocity.data(), p.velocity.data() + D);
            volume_.push_back(solid_ * p.volume);
        }
        for (auto const& name : to) self_.write(name, sluice::SolidPhase{id_, position_, velocity_, volume_});
    }

 private:
    sluice::Participant& self_;
    std::string from_;
    double solid_ = 0;  //!< volume of solid in that of a point at the start [-]
    std::optional<sluice::Sampled<sluice::BodyForce>> samples_;
    ranks::KnownToAll<sluice::BodyForce> known_;
    Vec<D> force_ = Vec<D>::Zero();
    std::vector<std::int64_t> id_;
    std::vector<double> position_, velocity_, volume_;
};

//! What the summary says about the start and the work with grains; a checkpoint keeps it, for that of a resumed run.
struct Start
{
    double height = 0, front = 0;     //!< [m]
    double step = 0;                  //!< [s]
    double balance = 0;               //!< of the energies [J]
    double front_depth = 0;           //!< if none is named [m]
    double contacts = 0, sweeps = 0;  //!< with grains, summed over the steps

    void keep(sluice::State& state) const
    {
        state.put("start", std::vector<double>{height, front, step, balance, front_depth, contacts, sweeps});
    }
    static Start kept(sluice::State const& state)
    {
        auto const numbers = state.numbers("start", 7);
        return {numbers[0], numbers[1], numbers[2], numbers[3], numbers[4], numbers[5], numbers[6]};
    }
};

//! One window in steps of our own: with `step: auto` as long as the speeds allow, what is left shared out evenly.
template <int D>
void advance(Solver<D>& solver, Config const& config, sluice::Window const& window, GrainEdge<D>& edge,
             FluidEdge<D>& fluid, Start& work)
{
    if (edge.exists()) edge.begin(window);
    if (fluid.exists()) fluid.begin(window);
    auto const step = [&](double done, double dt) {
        if (fluid.exists()) solver.set_loads(fluid.loads(window.begin + done + 0.5 * dt, solver.count()));
        if (edge.exists()) solver.set_grains(edge.grains(window.begin + done + dt, dt));
        solver.step(dt);
        if (!edge.exists()) return;
        edge.add(solver.grains().pushes(), window.length);
        work.contacts += static_cast<double>(solver.grains().contacts());
        work.sweeps += solver.grains().sweeps();
    };
    if (config.step) {
        std::int64_t const steps = window.steps(*config.step);
        double const dt = window.length / static_cast<double>(steps);
        for (std::int64_t k = 0; k < steps; ++k) step(static_cast<double>(k) * dt, dt);
        return;
    }
    double done = 0;
    while (true) {
        double const left = window.length - done;
        auto const steps_at = [&](double time) {
            if (edge.exists()) solver.set_grains(edge.grains(time, 0));
            return std::max(1.0, std::ceil(left / solver.longest_step() - 1e-9));
        };
        // a step has the grains of its end, which may be faster
        double steps = steps_at(window.begin + done);
        for (double more; (more = steps_at(window.begin + done + left / steps)) > steps;) steps = more;
        step(done, left / steps);
        if (steps == 1) return;
        done += left / steps;
    }
}

template <int D>
void describe(Solver<D> const& solver, Config const& config)
{
    std::printf("mpm: %zu points in cells of %g m\n", solver.state().points.size(), config.cell);
    std::printf("mpm: longest step %.4g s (Courant number %g; limit %.4g s)\n",
                config.step ? *config.step : solver.longest_step(), config.courant, largest_courant * solver.limit());
}

template <int D>
Start start_of(Config const& config, Solver<D> const& solver)
{
    auto const r = run_out_of(solver.setup(), solver.state(), 0);
    double const step = config.step ? *config.step : solver.longest_step();
    double volume = 0;
    for (Point<D> const& p : solver.state().points) volume += p.volume / girth(config.symmetry, p.place);
    double const area = D == 2 ? volume : volume / config.size[1];
    return {r.height, r.foremost, step, solver.energies().balance(), front_share * std::sqrt(area), 0, 0};
}

//! What a run leaves behind. All processes make the same calls; the first, which then has all points, writes.
template <int D>
class Recording
{
 public:
    Recording(sluice::Participant& self, Solver<D> const& solver, Extras extras)
        : self_(self), solver_(solver), extras_(extras)
    {}

    void begin(std::optional<double> resumed_at)
    {
        if (self_.rank() > 0) return;
        recorder_.emplace(sluice::RunNames{self_.directory(), self_.name(), self_.scene().hash}, extras_, resumed_at);
        if (auto const remark = recorder_->remark(); !remark.empty()) self_.warn(remark);
    }
    void picture(double time)
    {
        auto const& state = solver_.state();
        if (recorder_) recorder_->picture(time, state);
    }
    void row(double time, double front_depth, double balance, Vec<D> const& impulse, Vec<D> const& fluid)
    {
        solver_.state();
        if (recorder_) recorder_->row(time, solver_, front_depth, balance, impulse, fluid);
    }
    void close()
    {
        if (recorder_) recorder_->close();
    }

 private:
    sluice::Participant& self_;
    Solver<D> const& solver_;
    Extras extras_;
    std::optional<Recorder<D>> recorder_;
};

//! Of several processes the first, which has all points.
template <int D>
void tell_at_end(sluice::Participant& self, Config const& config, Solver<D> const& solver, Start const& start,
                 bool grains)
{
    auto const r = run_out_of(solver.setup(), solver.state(), config.front_depth.value_or(start.front_depth));
    auto const steps = static_cast<double>(std::max<std::int64_t>(1, solver.state().steps));
    self.fact("points", static_cast<double>(solver.count()));
    self.fact("H0 [m]", start.height);
    self.fact("L0 [m]", start.front);
    self.fact("longest step [s]", start.step);
    self.fact("steps", steps);
    self.fact("final run-out [m]", r.front);
    self.fact("final height [m]", r.height);
    self.fact("nodes of almost no mass, a step", static_cast<double>(solver.light_nodes()) / steps);
    if (grains) {
        self.fact("contacts with grains, a step", start.contacts / steps);
        self.fact("sweeps over them, a step", start.sweeps / steps);
    }
    double all = 1;
    for (int const cells : solver.setup().cells) all *= cells + 1 + 2 * rings_of_nodes(config.basis, D);
    self.skipped("empty cells", "nodes that no point reaches do not exist",
                 1 - static_cast<double>(solver.nodes()) / all);
}

//! What the scene's check needs to know of a run.
template <int D>
void check_run(sluice::Participant& self, Config const& config)
{
    GrainEdge<D> const edge(self, config.cell, nullptr);
    FluidEdge<D> const fluid(self, config.fluid, nullptr);
    auto const solver = make_solver<D>(config);
    require_shareable(solver.setup(), solver.count(), self.ranks());
    self.propose_window((edge.exists() ? share_of_a_step : steps_of_a_window) * start_of(config, solver).step);
    describe(solver, config);
}

//! Of several processes, all of which call it, the first speaks with partners.
template <int D>
void run(sluice::Participant& self, Config const& config)
{
    if (self.checking()) return check_run<D>(self, config);
    auto const peers = self.ranks() > 1 ? ranks::mpi_peers(self.rank(), self.ranks()) : nullptr;
    Solver<D> solver = make_solver<D>(config, peers.get());
    Start start = start_of(config, solver);
    GrainEdge<D> edge(self, config.cell, peers.get());
    FluidEdge<D> fluid(self, config.fluid, peers.get());
    solver.set_friction(config.grain_friction.value_or(0));
    if (!edge.exists()) self.skipped("grains", "no participant sends kinematics", 1.0);
    self.propose_window((edge.exists() ? share_of_a_step : steps_of_a_window) * start.step);
    self.keeps(
        [&](sluice::State& state) {
            keep(solver, state);
            start.keep(state);
        },
        [&](sluice::State const& state) {
            restore(solver, state);
            start = Start::kept(state);
        });
    auto const front_depth = [&] { return config.front_depth.value_or(start.front_depth); };
    bool const works = (config.rotation && config.rotation->ramp > 0) || solver.setup().period.norm() > 0;
    Recording<D> recording(self, solver,
                           {.field_work = works,
                            .grains = edge.exists(),
                            .fluid = fluid.exists(),
                            .rings = config.symmetry == Symmetry::axial});
    if (!self.resumes()) {
        recording.begin(std::nullopt);
        recording.picture(0.0);
        recording.row(0.0, front_depth(), start.balance, Vec<D>::Zero(), Vec<D>::Zero());
        edge.tell();
        fluid.tell(solver);
    }
    sluice::Windows windows = self.windows();
    if (self.resumes()) recording.begin(self.resumed_at());
    bool const iterates = !self.scene().implicit.empty();
    for (sluice::Window const& window : windows) {
        if (self.went_back()) recording.begin(self.resumed_at());
        advance(solver, config, window, edge, fluid, start);
        edge.tell();
        fluid.tell(solver);
        if (iterates && !self.accepted(window)) continue;
        if (window.output) recording.picture(window.end);
        if (window.series)
            recording.row(window.end, front_depth(), start.balance, edge.impulse(window.length),
                          window.length * fluid.force());
    }
    solver.state();  // to the first
    if (self.rank() > 0) return;
    tell_at_end(self, config, solver, start, edge.exists());
    recording.close();
}

void take_part(sluice::Participant& self)
{
    self.sends({"load", "phase"});
    self.takes({"kinematics", "body_force"});
    auto const& scene = self.scene();
    auto reader = self.config();
    Beside const beside{.grains = !self.senders("kinematics").empty(),
                        .fluid = !self.senders("body_force").empty() || !self.receivers("phase").empty(),
                        .rotation = self.rotation(),
                        .processes = self.ranks()};
    Config const config = read_config(reader, scene.dimension, scene.gravity, beside);
    ranks::refuse_restart(scene, self.name());
    if (self.rank() > 0) self.covers({{1, 1, 1}, {-1, -1, -1}});  // nothing: the first process hears for all
    scene.dimension == 2 ? run<2>(self, config) : run<3>(self, config);
}

}  // namespace

int main(int argc, char** argv)
{
    return sluice::run(argc, argv, take_part);
}

}  // namespace mpm
