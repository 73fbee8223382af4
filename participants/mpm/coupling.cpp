#include "participants/mpm/coupling.hpp"

#include <cmath>
#include <cstdio>
#include <optional>

#include "coupler/coupler.hpp"
#include "participants/mpm/checkpoint.hpp"
#include "participants/mpm/measures.hpp"
#include "participants/mpm/recorder.hpp"
#include "participants/mpm/setup.hpp"

namespace mpm {
namespace {

constexpr double front_share = 0.05;      // of the root of the area at the start: 2 to 3 grains, if it has 3000
constexpr double steps_of_a_window = 50;  // without a partner a window only paces the output

//! One window in steps of our own: with `step: auto` as long as the speeds allow, what is left shared out evenly.
template <int D>
void advance(Solver<D>& solver, Config const& config, sluice::Window const& window)
{
    if (config.step) {
        std::int64_t const steps = window.steps(*config.step);
        for (std::int64_t k = 0; k < steps; ++k) solver.step(window.length / static_cast<double>(steps));
        return;
    }
    double done = 0;
    while (true) {
        double const left = window.length - done;
        auto const steps = std::max(1.0, std::ceil(left / solver.longest_step() - 1e-9));
        solver.step(left / steps);
        if (steps == 1) return;
        done += left / steps;
    }
}

template <int D>
void describe(Solver<D> const& solver, Config const& config)
{
    std::printf("mpm: %zu points in cells of %g m\n", solver.state().points.size(), config.cell);
    std::printf("mpm: longest step %.4g s (Courant number %g; limit %.4g s)\n",
                config.step ? *config.step : solver.longest_step(), config.courant, solver.limit());
}

//! What the summary says about the start; a checkpoint keeps it, for the summary of a resumed run.
struct Start
{
    double height = 0, front = 0;  //!< [m]
    double step = 0;               //!< [s]
    double balance = 0;            //!< of the energies [J]
    double front_depth = 0;        //!< if none is named [m]

    void keep(sluice::State& state) const
    {
        state.put("start", std::vector<double>{height, front, step, balance, front_depth});
    }
    static Start kept(sluice::State const& state)
    {
        auto const numbers = state.numbers("start", 5);
        return {numbers[0], numbers[1], numbers[2], numbers[3], numbers[4]};
    }
};

template <int D>
Start start_of(Config const& config, Solver<D> const& solver)
{
    auto const r = run_out_of(solver.setup(), solver.state(), 0);
    double const step = config.step ? *config.step : solver.longest_step();
    double volume = 0;
    for (Point<D> const& p : solver.state().points) volume += p.volume;
    double const area = D == 2 ? volume : volume / config.size[1];
    return {r.height, r.foremost, step, solver.energies().balance(), front_share * std::sqrt(area)};
}

template <int D>
void run(sluice::Participant& self, Config const& config)
{
    Solver<D> solver = make_solver<D>(config);
    Start start = start_of(config, solver);
    self.propose_window(steps_of_a_window * start.step);
    if (self.checking()) return describe(solver, config);
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
    std::optional<Recorder<D>> recorder;
    auto const begin_recording = [&](std::optional<double> resumed_at) {
        recorder.emplace(sluice::RunNames{self.directory(), self.name(), self.scene().hash}, resumed_at);
        if (auto const remark = recorder->remark(); !remark.empty()) self.warn(remark);
    };
    if (!self.resumes()) {
        begin_recording(std::nullopt);
        recorder->picture(0.0, solver.state());
        recorder->row(0.0, solver, front_depth(), start.balance);
    }
    sluice::Windows windows = self.windows();
    if (self.resumes()) begin_recording(self.resumed_at());
    for (sluice::Window const& window : windows) {
        if (self.went_back()) begin_recording(self.resumed_at());
        advance(solver, config, window);
        if (window.output) recorder->picture(window.end, solver.state());
        if (window.series) recorder->row(window.end, solver, front_depth(), start.balance);
    }
    auto const r = run_out_of(solver.setup(), solver.state(), front_depth());
    auto const steps = static_cast<double>(std::max<std::int64_t>(1, solver.state().steps));
    self.fact("points", static_cast<double>(solver.state().points.size()));
    self.fact("H0 [m]", start.height);
    self.fact("L0 [m]", start.front);
    self.fact("longest step [s]", start.step);
    self.fact("steps", steps);
    self.fact("final run-out [m]", r.front);
    self.fact("final height [m]", r.height);
    self.fact("nodes of almost no mass, a step", static_cast<double>(solver.light_nodes()) / steps);
    double all = 1;
    for (int const cells : solver.setup().cells) all *= cells + 3;
    self.skipped("empty cells", "nodes that no point reaches do not exist",
                 1 - static_cast<double>(solver.nodes()) / all);
    recorder->close();
}

void take_part(sluice::Participant& self)
{
    self.sends({});
    self.takes({});
    auto const& scene = self.scene();
    auto reader = self.config();
    Config const config = read_config(reader, scene.dimension, scene.gravity);
    sluice::require(self.ranks() == 1, [&] {
        return sluice::Error("mpm: ranks = " + std::to_string(self.ranks()) + " (needed: ranks: 1, or none).");
    });
    scene.dimension == 2 ? run<2>(self, config) : run<3>(self, config);
}

}  // namespace

int main(int argc, char** argv)
{
    return sluice::run(argc, argv, take_part);
}

}  // namespace mpm
