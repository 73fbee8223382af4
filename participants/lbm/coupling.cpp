#include "participants/lbm/coupling.hpp"

#include <cmath>
#include <cstdio>
#include <optional>

#include "coupler/coupler.hpp"
#include "coupler/record/archive.hpp"
#include "coupler/record/image_series.hpp"
#include "coupler/record/table.hpp"
#include "participants/lbm/solver.hpp"

namespace lbm {
namespace {

std::vector<float> narrowed(std::vector<double> const& values)
{
    return {values.begin(), values.end()};
}

//! What a run leaves behind: ParaView series, HDF5 archive, time series. A resumed run goes on with what is there up to
//! `resumed_at` [s].
class Recorder
{
 public:
    Recorder(sluice::Participant& self, Config const& config, std::optional<double> resumed_at = std::nullopt)
        : coarsen_(self.scene().coarsen),
          lattice_(lattice_of(config, coarsen_)),
          series_(self.directory(), self.name(), lattice_, resumed_at),
          archive_(self.directory() / (self.name() + ".h5"),
                   std::vector<sluice::ArchiveFact>{
                       {"scene_hash", std::to_string(self.scene().hash)},
                       {"origin", std::vector<double>{lattice_.origin[0], lattice_.origin[1]}},
                       {"spacing", std::vector<double>{lattice_.spacing[0], lattice_.spacing[1]}}},
                   resumed_at),
          table_(self.directory() / (self.name() + ".csv"),
                 std::vector<std::string>{"time [s]", "max_speed [m/s]", "mass [kg/m]", "momentum_x [N s/m]",
                                          "momentum_y [N s/m]", "window_impulse_x [N s/m]", "window_impulse_y [N s/m]"},
                 resumed_at)
    {
        if (auto const remark = archive_.remark(series_.frames()); !remark.empty()) self.warn(remark);
    }

    void picture(double time, Solver& solver)
    {
        auto const f = solver.fields(coarsen_);
        auto const velocity = narrowed(f.velocity), pressure = narrowed(f.pressure), vorticity = narrowed(f.vorticity),
                   solid = narrowed(f.solid_fraction);
        series_.append(time, std::vector<sluice::CellColumn>{{"velocity", "m/s", 2, velocity},
                                                             {"pressure", "Pa", 1, pressure},
                                                             {"vorticity", "1/s", 1, vorticity},
                                                             {"solid_fraction", "", 1, solid}});
        auto const nx = static_cast<std::size_t>(f.nx), ny = static_cast<std::size_t>(f.ny);
        auto const pack = sluice::Pack::deflate;
        archive_.append(time, std::vector<sluice::ArchiveDataset>{
                                  {"velocity", "m/s", std::span<float const>(velocity), {ny, nx, 2}, pack},
                                  {"pressure", "Pa", std::span<float const>(pressure), {ny, nx}, pack},
                                  {"vorticity", "1/s", std::span<float const>(vorticity), {ny, nx}, pack},
                                  {"solid_fraction", "", std::span<float const>(solid), {ny, nx}, pack}});
    }

    //! `impulse`: what the fluid gave to all grains in the last window [N s/m].
    void row(double time, Solver& solver, std::array<double, 2> impulse)
    {
        auto const momentum = solver.momentum();
        table_.append(std::vector<double>{time, solver.max_speed(), solver.mass(), momentum[0], momentum[1], impulse[0],
                                          impulse[1]});
    }

    void close() { archive_.close(); }

 private:
    //! Of the blocks that Solver::fields() makes.
    static sluice::Lattice lattice_of(Config const& config, int coarsen)
    {
        auto const [nx, ny] = config.cells();
        double const spacing = coarsen * config.cell;
        auto const blocks = [&](std::ptrdiff_t n) { return static_cast<std::size_t>((n + coarsen - 1) / coarsen); };
        return {{config.origin[0], config.origin[1], 0.0}, {spacing, spacing, spacing}, {blocks(nx), blocks(ny), 0}};
    }

    int coarsen_;
    sluice::Lattice lattice_;
    sluice::ImageSeries series_;
    sluice::Archive archive_;
    sluice::Table table_;
};

//! Mean force and torque on each disc over the steps of one window: the impulse that the fluid gave, over its length.
struct MeanLoad
{
    std::vector<std::int64_t> id;
    std::vector<double> force, torque;

    void restart(std::span<std::int64_t const> ids)
    {
        id.assign(ids.begin(), ids.end());
        force.assign(2 * ids.size(), 0.0);
        torque.assign(ids.size(), 0.0);
    }
    void add(LoadsView const& loads, double share)
    {
        for (std::size_t k = 0; k < force.size(); ++k) force[k] += share * loads.force[k];
        for (std::size_t k = 0; k < torque.size(); ++k) torque[k] += share * loads.torque[k];
    }
    std::array<double, 2> impulse(double length) const
    {
        std::array<double, 2> sum{};
        for (std::size_t k = 0; k < force.size(); ++k) sum[k % 2] += force[k];
        return {sum[0] * length, sum[1] * length};
    }
    sluice::Load view() const { return {id, force, torque}; }
};

//! How the work was shared out, summed over the steps of the run; for the summary.
struct Shares
{
    double covered_cells = 0, rebuilt_discs = 0, steps = 0;

    void add(Share const& share)
    {
        covered_cells += share.covered_cells;
        rebuilt_discs += share.rebuilt_discs;
        steps += 1;
    }
    void keep(sluice::State& state) const
    {
        state.put("shares", std::vector<double>{covered_cells, rebuilt_discs, steps});
    }
    static Shares kept(sluice::State const& state)
    {
        auto const numbers = state.numbers("shares", 3);
        return {numbers[0], numbers[1], numbers[2]};
    }
};

DiscsView discs_of(sluice::Kinematics const& k)
{
    // lasting ids are the same bits, signed there and unsigned here
    std::span<std::uint64_t const> const ids(reinterpret_cast<std::uint64_t const*>(k.id.data()), k.id.size());
    return {k.position, k.velocity, k.angular_velocity, k.radius, ids};
}

Config read(sluice::Participant& self)
{
    self.sends({"load"});
    self.takes({"kinematics"});
    sluice::require(self.scene().dimension == 2,
                    [] { return sluice::Error("lbm: dimension = 3 (this lattice is D2Q9; needed: dimension: 2)."); });
    auto reader = self.config();
    auto const& gravity = self.scene().gravity;
    return read_config(reader, {gravity[0], gravity[1]});
}

void take_part(sluice::Participant& self)
{
    Config const config = read(self);
    for (auto const& line : describe(config))
        if (self.checking()) std::printf("fluid: %s\n", line.c_str());
    for (auto const& issue : find_issues(config)) {
        if (self.checking()) std::printf("fluid: warning: %s: %s\n", issue.key.c_str(), issue.text.c_str());
        self.warn(issue.key + ": " + issue.text);
    }
    self.propose_window(config.step, true);
    if (self.checking()) return;

    Solver solver(config);
    Shares shares;
    self.keeps(
        [&](sluice::State& state) {
            solver.keep(state);
            shares.keep(state);
        },
        [&](sluice::State const& state) {
            solver.restore(state);
            shares = Shares::kept(state);
        });
    std::optional<Recorder> recorder;
    if (!self.resumes()) recorder.emplace(self, config);
    self.fact("cells", static_cast<double>(config.cells()[0] * config.cells()[1]));
    self.fact("time step [s]", config.step);
    self.fact("relaxation time", config.relaxation_time());
    auto const senders = self.senders("kinematics"), receivers = self.receivers("load");
    sluice::require(senders.size() <= 1, [] {
        return sluice::Error("lbm: kinematics from more than one participant (at most one sends them).");
    });

    MeanLoad load;
    auto tell = [&] {
        for (auto const& to : receivers) self.write(to, load.view());
    };
    if (!self.resumes()) tell();
    sluice::Windows windows = self.windows();
    if (self.resumes()) recorder.emplace(self, config, self.resumed_at());
    bool const iterates = !self.scene().implicit.empty();  // windows may be computed several times before they stand
    for (sluice::Window const& window : windows) {
        if (self.went_back()) recorder.emplace(self, config, self.resumed_at());
        auto const steps = static_cast<std::int64_t>(std::lround(window.length / config.step));
        for (std::int64_t k = 0; k < steps; ++k) {
            if (!senders.empty()) {
                auto kinematics = self.read<sluice::Kinematics>(senders[0], window);
                auto const discs = kinematics.at(window.begin + (static_cast<double>(k) + 0.5) * config.step);
                if (k == 0) load.restart(discs.id);
                solver.set_discs(discs_of(discs));
            }
            if (k == 0 && window.index == 0 && window.iteration == 0) {
                recorder->picture(0.0, solver);
                recorder->row(0.0, solver, {});
            }
            solver.step();
            load.add(solver.loads(), 1.0 / static_cast<double>(steps));
            shares.add(solver.share());
        }
        tell();
        if (iterates && !self.accepted(window)) continue;
        if (window.output) recorder->picture(window.end, solver);
        if (window.series) recorder->row(window.end, solver, load.impulse(window.length));
    }
    self.skipped("grain kernel", "cells that no grain covers run the plain fluid kernel",
                 1 - shares.covered_cells / shares.steps);
    self.skipped("area fractions", "discs that moved too little keep those of the step before",
                 1 - shares.rebuilt_discs / shares.steps);
    recorder->close();
}

}  // namespace

int main(int argc, char** argv)
{
    return sluice::run(argc, argv, take_part);
}

}  // namespace lbm
