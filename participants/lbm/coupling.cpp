#include "participants/lbm/coupling.hpp"

#include <algorithm>
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
template <int D>
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
                       {"origin", std::vector<double>(lattice_.origin.begin(), lattice_.origin.begin() + D)},
                       {"spacing", std::vector<double>(lattice_.spacing.begin(), lattice_.spacing.begin() + D)}},
                   resumed_at),
          table_(self.directory() / (self.name() + ".csv"), columns(config), resumed_at)
    {
        if (auto const remark = archive_.remark(series_.frames()); !remark.empty()) self.warn(remark);
    }

    void picture(double time, Solver<D>& solver)
    {
        auto const f = solver.fields(coarsen_);
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

    //! `impulse`: what the fluid gave to all grains in the last window [N s].
    //! `solids`: mean force on each solid at rest in that window [N].
    void row(double time, Solver<D>& solver, std::array<double, D> const& impulse, std::vector<double> const& solids)
    {
        std::vector<double> values{time, solver.max_speed(), solver.mass()};
        for (double const component : solver.momentum()) values.push_back(component);
        values.insert(values.end(), impulse.begin(), impulse.end());
        values.insert(values.end(), solids.begin(), solids.end());
        table_.append(values);
    }

    void close() { archive_.close(); }

 private:
    //! Of the blocks that Solver::fields() makes.
    static sluice::Lattice lattice_of(Config const& config, int coarsen)
    {
        auto const [nx, ny, nz] = config.cells();
        double const spacing = coarsen * config.cell;
        auto const blocks = [&](std::ptrdiff_t n) { return static_cast<std::size_t>((n + coarsen - 1) / coarsen); };
        return {config.origin, {spacing, spacing, spacing}, {blocks(nx), blocks(ny), D == 2 ? 0 : blocks(nz)}};
    }
    static std::vector<std::string> columns(Config const& config)
    {
        std::string const per = D == 2 ? "/m]" : "]";
        std::vector<std::string> names{"time [s]", "max_speed [m/s]", "mass [kg" + per};
        for (std::string const what : {"momentum_", "window_impulse_"})
            for (std::size_t k = 0; k < D; ++k) names.push_back(what + "xyz"[k] + " [N s" + per);
        for (Solid const& solid : config.solids)
            for (std::size_t k = 0; k < D; ++k) names.push_back(solid.name + "_force_" + "xyz"[k] + " [N" + per);
        return names;
    }

    int coarsen_;
    sluice::Lattice lattice_;
    sluice::ImageSeries series_;
    sluice::Archive archive_;
    sluice::Table table_;
};

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
    double covered_cells = 0, rebuilt_bodies = 0, steps = 0;

    void add(Share const& share)
    {
        covered_cells += share.covered_cells;
        rebuilt_bodies += share.rebuilt_bodies;
        steps += 1;
    }
    void keep(sluice::State& state) const
    {
        state.put("shares", std::vector<double>{covered_cells, rebuilt_bodies, steps});
    }
    static Shares kept(sluice::State const& state)
    {
        auto const numbers = state.numbers("shares", 3);
        return {numbers[0], numbers[1], numbers[2]};
    }
};

BodiesView bodies_of(sluice::Kinematics const& k)
{
    // lasting ids are the same bits, signed there and unsigned here
    std::span<std::uint64_t const> const ids(reinterpret_cast<std::uint64_t const*>(k.id.data()), k.id.size());
    return {k.position, k.velocity, k.angular_velocity, k.radius, ids};
}

//! Solids finer than a cell: where they are at the start of a window, and the mean force on them in it.
template <int D>
class PhaseEdge
{
 public:
    explicit PhaseEdge(sluice::Participant& self) : self_(self), receivers_(self.receivers("body_force"))
    {
        auto const senders = self.senders("phase");
        sluice::require(senders.size() <= 1, [] {
            return sluice::Error("lbm: phase from more than one participant (at most one sends it).");
        });
        if (!senders.empty()) from_ = senders[0];
    }
    bool exists() const { return !from_.empty(); }

    void begin(sluice::Window const& window, std::int64_t steps, Solver<D>& solver)
    {
        auto sampled = self_.read<sluice::SolidPhase>(from_, window);
        auto const points = sampled.at(window.begin);
        id_.assign(points.id.begin(), points.id.end());
        solver.set_phase({points.id, points.position, points.velocity, points.solid_volume}, steps);
    }
    void tell(Solver<D>& solver)
    {
        for (auto const& to : receivers_) self_.write(to, sluice::BodyForce{id_, solver.phase_force()});
    }

 private:
    sluice::Participant& self_;
    std::vector<std::string> receivers_;
    std::string from_;
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
                       rotation ? std::optional(*rotation) : std::nullopt, phase);
}

template <int D>
void run(sluice::Participant& self, Config const& config)
{
    Solver<D> solver(config);
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
    std::optional<Recorder<D>> recorder;
    if (!self.resumes()) recorder.emplace(self, config);
    self.fact("cells", static_cast<double>(config.cells()[0] * config.cells()[1] * config.cells()[2]));
    if (!solver.layout().whole()) {
        self.fact("cells that are stored", static_cast<double>(solver.layout().stored()));
        self.note(std::to_string(solver.layout().stored()) +
                  " cells hold fluid or are near it; the others, deep in solids "
                  "at rest, are not stored");
    }
    self.fact("time step [s]", config.step);
    self.fact("relaxation time", config.relaxation_time());
    if (config.phase) self.fact("bulk modulus of the fluid [Pa]", config.units().pressure_unit() / 3);
    auto const senders = self.senders("kinematics"), receivers = self.receivers("load");
    sluice::require(senders.size() <= 1, [] {
        return sluice::Error("lbm: kinematics from more than one participant (at most one sends them).");
    });

    PhaseEdge<D> phase(self);
    MeanLoad<D> load;
    std::vector<double> on_solids(D * config.solids.size());  // mean force of a window
    auto tell = [&] {
        for (auto const& to : receivers) self.write(to, load.view());
        if (phase.exists()) phase.tell(solver);
    };
    if (!self.resumes()) tell();
    sluice::Windows windows = self.windows();
    if (self.resumes()) recorder.emplace(self, config, self.resumed_at());
    bool const iterates = !self.scene().implicit.empty();  // windows may be computed several times before they stand
    for (sluice::Window const& window : windows) {
        if (self.went_back()) recorder.emplace(self, config, self.resumed_at());
        auto const steps = static_cast<std::int64_t>(std::lround(window.length / config.step));
        if (phase.exists()) phase.begin(window, steps, solver);
        for (std::int64_t k = 0; k < steps; ++k) {
            if (!senders.empty()) {
                auto kinematics = self.read<sluice::Kinematics>(senders[0], window);
                auto const bodies = kinematics.at(window.begin + (static_cast<double>(k) + 0.5) * config.step);
                if (k == 0) load.restart(bodies.id);
                solver.set_bodies(bodies_of(bodies));
            }
            if (k == 0 && window.index == 0 && window.iteration == 0) {
                recorder->picture(0.0, solver);
                recorder->row(0.0, solver, {}, on_solids);
            }
            solver.step();
            if (k == 0) std::fill(on_solids.begin(), on_solids.end(), 0.0);
            for (std::size_t i = 0; i < on_solids.size(); ++i)
                on_solids[i] += solver.solid_loads().force[i] / static_cast<double>(steps);
            load.add(solver.loads(), 1.0 / static_cast<double>(steps));
            shares.add(solver.share());
        }
        tell();
        if (iterates && !self.accepted(window)) continue;
        if (window.output) recorder->picture(window.end, solver);
        if (window.series) recorder->row(window.end, solver, load.impulse(window.length), on_solids);
    }
    self.skipped("grain kernel", "cells that no grain covers run the plain fluid kernel",
                 1 - shares.covered_cells / shares.steps);
    self.skipped("solid fractions", "grains that moved too little keep those of the step before",
                 1 - shares.rebuilt_bodies / shares.steps);
    recorder->close();
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
