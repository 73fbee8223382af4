#include "participants/liggghts/coupling.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <optional>
#include <string>
#include <tuple>
#include <utility>

#include "coupler/coupler.hpp"
#include "coupler/record/atomic_file.hpp"
#include "participants/dem/measures.hpp"
#include "participants/dem/partner_loads.hpp"
#include "participants/dem/recorder.hpp"
#include "participants/dem/setup.hpp"
#include "participants/dem/start.hpp"
#include "participants/liggghts/drive.hpp"
#include "participants/liggghts/engine.hpp"
#include "participants/liggghts/mirror.hpp"
#include "participants/liggghts/observer.hpp"
#include "participants/liggghts/script.hpp"
#include "participants/liggghts/source.hpp"
#include "participants/liggghts/told.hpp"

namespace liggghts {
namespace {

constexpr double steps_of_a_dry_window = 50;  // without a partner a window only paces the output

//! What stands for the grains of a user's script before it has run: no walls, no laws.
template <int D>
dem::Setup<D> bare_setup(dem::Config const& config, dem::Grains<D> const& grains)
{
    dem::Setup<D> setup;
    setup.gravity = dem::to_dimension<D>(config.gravity);
    double smallest = grains.size() > 0 ? grains.place[0].radius : 1.0;
    for (auto const& place : grains.place) smallest = std::min(smallest, place.radius);
    setup.skin = dem::list_reach(2.0 * smallest);
    return setup;
}

template <int D>
class Run
{
 public:
    Run(sluice::Participant& self, Source const& source) : self_(self), source_(source) {}

    void operator()();

 private:
    dem::Config const& config() const { return source_.config; }
    std::filesystem::path file(std::string const& ending) const
    {
        return self_.directory() / (self_.name() + ".liggghts." + ending);
    }
    bool first() const { return self_.rank() == 0; }  //!< of the processes that share the grains: speaks for all
    double sum(double mine) const;
    void start_generated();
    void start_engine(std::filesystem::path const& restart, Loads applied);
    Mirror<D> all() const;
    void keep(sluice::State& state);
    void go_on(sluice::State const& state);
    void begin_recording(std::optional<double> resumed_at);
    void see();
    void look();
    void tell();
    void record(dem::Due const& due, dem::Vec<D> impulse);
    void advance(sluice::Window const& window);
    bool are_as_told(std::vector<sluice::Sampled<sluice::Load>> const& samples) const;
    void take_loads(std::vector<sluice::Sampled<sluice::Load>>& samples, double time, Loads& loads);
    std::size_t place_of_id(std::int64_t id);
    std::vector<Removal> removals(sluice::Window const& window, std::int64_t steps, double dt) const;

    sluice::Participant& self_;
    Source const& source_;
    SizeClasses classes_;
    std::vector<std::int64_t> ids_;  //!< of the tags 1, 2, ... of all processes; empty: they are the ids
    dem::Start start_;
    std::unique_ptr<Engine> engine_;
    std::optional<Drive> drive_;
    Told<D> told_{ids_};
    std::size_t largest_tag_ = 0;  //!< of all processes
    std::optional<Observer<D>> observer_;
    std::optional<dem::Recorder<D>> recorder_;
    std::optional<dem::Finder> find_;  //!< of ids_
    double work_ = 0.0;                //!< of their loads so far [J]
    double now_ = 0.0;                 //!< s
};

template <int D>
double Run<D>::sum(double mine) const
{
    engine_->sum(&mine, 1);
    return mine;
}

//! The grains of all processes, in each.
template <int D>
Mirror<D> Run<D>::all() const
{
    Mirror<D> mirror(ids_, engine_->rows());
    if (self_.ranks() == 1) return mirror;
    return mirror.whole(largest_tag_, [&](double* numbers, std::size_t count) { engine_->sum(numbers, count); });
}

//! The grains of the block as they are at t = 0.
template <int D>
void Run<D>::start_generated()
{
    auto const packing =
        dem::prepare_packing<D>(config(), dem::packing_cache(), [&](std::string const& line) { self_.note(line); });
    auto const solver = dem::make_solver(config(), packing);
    auto const& grains = solver.grains();
    start_ = dem::start_of(config(), solver);
    std::vector<double> radius;
    for (auto const& place : grains.place) radius.push_back(place.radius);
    classes_ = classes_of(grains.mass, radius, most_classes);
    ids_ = grains.id;
    sluice::write_atomically(file("data"), data_of(config(), grains, classes_));
}

template <int D>
void Run<D>::start_engine(std::filesystem::path const& restart, Loads applied)
{
    engine_ = std::make_unique<Engine>(file(restart.empty() ? "log" : "resumed.log"), self_.rank(), self_.ranks());
    if (first() && source_.generates()) {
        if (restart.empty()) start_generated();
        for (auto const& said : differences(config(), classes_)) self_.warn(said);
        std::string const grains =
            restart.empty() ? "read_data \"" + file("data").string() : "read_restart \"" + restart.string();
        sluice::write_atomically(file("in"), script_of(config(), classes_, grains + '"', now_));
    }
    engine_->share(ids_);  // and now its files are there
    run_script(*engine_, source_.generates() ? file("in") : source_.script, restart);
    drive_.emplace(*engine_);
    auto const& measures = config().measures;
    drive_->begin(std::move(applied),
                  {measures[dem::Measure::impulse].wanted, measures[dem::Measure::energies].wanted});
    see();
    observer_.emplace(source_.generates() ? dem::make_setup<D>(config()) : bare_setup(config(), all().grains()));
}

//! LIGGGHTS' own restart file, and what it does not know. It goes on as one that has read the file: with new lists.
template <int D>
void Run<D>::keep(sluice::State& state)
{
    auto const restart = file("restart");
    engine_->command("write_restart \"" + restart.string() + "\"", "checkpoint");
    auto const text = first() ? sluice::read_file(restart) : std::string();
    if (first()) std::filesystem::remove(restart);
    state.put("restart", std::as_bytes(std::span(text)));
    std::vector<double> class_mass, class_radius;
    for (auto const& [mass, radius] : classes_.classes) {
        class_mass.push_back(mass);
        class_radius.push_back(radius);
    }
    auto const& applied = drive_->applied();
    state.put("classes/mass", class_mass);
    state.put("classes/radius", class_radius);
    state.put("applied/tag", std::vector<std::int64_t>(applied.tags().begin(), applied.tags().end()));
    state.put("applied/force", applied.force);
    state.put("applied/torque", applied.torque);
    state.put("ids", ids_);
    state.put_number("time", now_);
    state.put_number("work", work_);
    start_.keep(state);
    engine_->evaluate();
    see();  // the rows may stand in another order now, in which a run that is resumed will have them
}

template <int D>
void Run<D>::go_on(sluice::State const& state)
{
    sluice::require(!engine_, [] {
        return sluice::Error("LIGGGHTS cannot go back in a run (needed: on-death: stop). `sluice resume` goes on.");
    });
    auto const restart = file("restart");
    auto const bytes = state.bytes("restart");
    if (first()) sluice::write_atomically(restart, bytes);
    auto const mass = state.numbers("classes/mass"), radius = state.numbers("classes/radius", mass.size());
    for (std::size_t c = 0; c < mass.size(); ++c) classes_.classes.push_back({mass[c], radius[c]});
    auto const ids = state.integers("ids");
    ids_.assign(ids.begin(), ids.end());
    auto const tags = state.integers("applied/tag");
    Loads applied;
    applied.set(std::vector<int>(tags.begin(), tags.end()), state.numbers("applied/force", 3 * tags.size()),
                state.numbers("applied/torque", 3 * tags.size()));
    now_ = state.number("time");
    work_ = state.number("work");
    start_ = dem::Start::kept(state);
    start_engine(restart, std::move(applied));
    if (first()) std::filesystem::remove(restart);
}

template <int D>
void Run<D>::begin_recording(std::optional<double> resumed_at)
{
    if (!first()) return;
    recorder_.emplace(sluice::RunNames{self_.directory(), self_.name(), self_.scene().hash}, config(),
                      start_.mean_diameter, resumed_at);
    if (auto const remark = recorder_->remark(); !remark.empty()) self_.warn(remark);
}

//! Where the grains are now.
template <int D>
void Run<D>::see()
{
    told_.update(engine_->rows());
    std::int64_t own = source_.generates() ? static_cast<std::int64_t>(ids_.size()) : 0;
    if (!source_.generates())
        for (int const tag : told_.tags()) own = std::max<std::int64_t>(own, tag);
    largest_tag_ = static_cast<std::size_t>(self_.ranks() > 1 ? engine_->largest(own) : own);
}

//! See, and that none is missing.
template <int D>
void Run<D>::look()
{
    see();
    if (!source_.generates()) return;
    double const count = sum(static_cast<double>(told_.tags().size()));
    sluice::require(count == static_cast<double>(ids_.size()), [&] {
        return sluice::Error("LIGGGHTS has " + std::to_string(static_cast<std::size_t>(count)) + " grains of " +
                                 std::to_string(ids_.size()) + ": others have left. Try a shorter step.",
                             sluice::Exit::numerical);
    });
}

template <int D>
void Run<D>::tell()
{
    for (auto const& to : self_.receivers("kinematics"))
        self_.write(to,
                    sluice::Kinematics{told_.id(), told_.position(), told_.velocity(), told_.spin(), told_.radius()});
}

template <int D>
void Run<D>::record(dem::Due const& due, dem::Vec<D> impulse)
{
    if (!dem::is_anything_due(config().measures, due)) return;
    Mirror<D> const mirror = all();
    double const work = sum(work_);
    if (!first()) return;
    auto grains = mirror.grains();
    auto const& acting = drive_->applied();
    auto const found = acting.by_tag();
    for (std::size_t k = 0; k < grains.size(); ++k) {
        auto const tag = static_cast<std::size_t>(mirror.tags()[k]);
        if (tag >= found.size() || found[tag] == Loads::nobody) continue;
        double const* next = &acting.force[3 * found[tag]];
        dem::each_number(grains.external[k].force, [&](double& number) { number = *next++; });
    }
    dem::Columns<D> columns;
    columns.update(grains);
    recorder_->record(due, columns, {observer_->look(grains, now_, work), impulse, start_.balance});
}

//! The walls that vanish in this window; each in the nearest step.
template <int D>
std::vector<Removal> Run<D>::removals(sluice::Window const& window, std::int64_t steps, double dt) const
{
    std::vector<Removal> found;
    auto const& walls = config().walls;
    for (std::size_t w = 0; w < walls.size(); ++w) {
        if (!(walls[w].removed_at > 0.0)) continue;  // was never there
        double const at = (walls[w].removed_at - window.begin) / dt - 0.5;
        if (!(at > -1.0) || !(at <= static_cast<double>(steps - 1))) continue;
        found.push_back({static_cast<std::int64_t>(std::ceil(std::max(at, 0.0))), wall_name(w)});
    }
    std::ranges::sort(found, {}, &Removal::step);
    return found;
}

//! A partner usually answers in the order in which it was told.
template <int D>
bool Run<D>::are_as_told(std::vector<sluice::Sampled<sluice::Load>> const& samples) const
{
    return self_.ranks() == 1 && std::ranges::all_of(samples, [&](auto const& sample) {
               return std::ranges::equal(sample.ids(), told_.id());
           });
}

//! Of a grain among the tags 1, 2, ...
template <int D>
std::size_t Run<D>::place_of_id(std::int64_t id)
{
    if (!source_.generates()) return static_cast<std::size_t>(id) - 1;  // a script's tags are ids
    if (!find_) find_.emplace(ids_);
    return (*find_)(id);
}

//! What all partners do at this time: in the order of the rows, or else of the tags.
template <int D>
void Run<D>::take_loads(std::vector<sluice::Sampled<sluice::Load>>& samples, double time, Loads& loads)
{
    bool const as_told = are_as_told(samples);
    std::vector<int> all_tags;
    if (!as_told) {
        all_tags.resize(largest_tag_);
        std::iota(all_tags.begin(), all_tags.end(), 1);
    }
    bool const at_once = D == 3 && as_told && !samples.empty();  // the first is not added, but copied
    if (!at_once) loads.reset(as_told ? told_.tags() : all_tags);
    constexpr std::size_t turning = D == 2 ? 1 : 3;
    for (auto& sample : samples) {
        auto const load = sample.at(time);
        if (at_once && &sample == &samples.front()) {
            loads.set(told_.tags(), load.force, load.torque);
            continue;
        }
        for (std::size_t n = 0; n < load.id.size(); ++n) {
            std::size_t const to = as_told ? n : place_of_id(load.id[n]);
            if (to >= loads.tags().size()) continue;  // has left since it was told of
            for (std::size_t k = 0; k < D; ++k) loads.force[3 * to + k] += load.force[D * n + k];
            for (std::size_t k = 0; k < turning; ++k)
                loads.torque[3 * to + (3 - turning) + k] += load.torque[turning * n + k];
        }
    }
    if (self_.ranks() > 1 && !samples.empty())  // each process was told of the grains that it had
        for (auto* numbers : {&loads.force, &loads.torque}) engine_->sum(numbers->data(), numbers->size());
}

//! One window in equal steps; what partners do is sampled in the middle of each, or once if it stays the same.
template <int D>
void Run<D>::advance(sluice::Window const& window)
{
    std::vector<sluice::Sampled<sluice::Load>> samples;
    for (auto const& from : self_.senders("load")) samples.push_back(self_.read<sluice::Load>(from, window));
    std::int64_t const steps = window.steps(config().step);
    double const dt = window.length / static_cast<double>(steps);
    bool const vary = sum(std::ranges::any_of(samples, &sluice::Sampled<sluice::Load>::vary) ? 1.0 : 0.0) > 0.0;
    auto const load = [&](std::int64_t step, Loads& loads) {
        take_loads(samples, window.begin + (static_cast<double>(step) + 0.5) * dt, loads);
    };
    auto const given = drive_->advance(steps, dt, load, vary, removals(window, steps, dt));
    work_ += given.work;
    now_ = window.end;
    look();
    tell();
    record({window.end, window.output, window.series, [&](double interval) { return window.due(interval); }},
           dem::to_dimension<D>({given.impulse[0], given.impulse[1], given.impulse[2]}));
}

template <int D>
void Run<D>::operator()()
{
    self_.keeps([&](sluice::State& state) { keep(state); }, [&](sluice::State const& state) { go_on(state); });
    if (self_.senders("load").empty()) self_.skipped("fluid", "no participant sends a load: it is not started", 1.0);
    if (!self_.resumes()) {
        start_engine({}, {});
        if (!source_.generates()) start_ = dem::start_of(config(), observer_->look(all().grains(), 0.0, 0.0));
        tell();
        begin_recording(std::nullopt);
        record({0.0, true, true, [](double) { return true; }}, {});
    }
    sluice::Windows windows = self_.windows();
    if (self_.resumes()) begin_recording(self_.resumed_at());
    if (first())
        for (auto const& [name, value] : dem::facts_of(config(), start_)) self_.fact(name, value);
    for (sluice::Window const& window : windows) advance(window);
    auto const runout = dem::run_out_of(all().grains());
    if (!first()) return;
    self_.fact("final run-out [m]", runout.front);
    self_.fact("final height [m]", runout.height);
    self_.fact("in LIGGGHTS' own steps [s]", engine_->times().own);
    recorder_->close();
}

//! What LIGGGHTS cannot be asked for, of the scene outside of the block.
void check_scene(sluice::Participant const& self)
{
    auto const& scene = self.scene();
    sluice::require(scene.implicit.empty(), [] {
        return sluice::Error(
            "LIGGGHTS cannot repeat a window (needed for `implicit`: a solver that goes back to its state). Try the "
            "serial scheme, one edge with lag: 1 and predict: linear, or solver: dem.");
    });
    sluice::require(!scene.restart_on_death, [] {
        return sluice::Error("LIGGGHTS cannot go back in a run (needed: on-death: stop). `sluice resume` goes on.");
    });
}

void take_part(sluice::Participant& self)
{
    self.sends({"kinematics"});
    self.takes({"load"});
    auto const& gravity = self.scene().gravity;
    int const dimension = self.scene().dimension;
    Source const source = read_source(self.config(), dimension, {gravity[0], gravity[1], gravity[2]});
    if (self.rank() == 0)
        for (auto const& warning : source.config.warnings) self.warn(warning);
    check_scene(self);
    self.propose_window(steps_of_a_dry_window * source.config.step);
    if (self.checking()) return;
    dimension == 2 ? Run<2>(self, source)() : Run<3>(self, source)();
}

}  // namespace

int main(int argc, char** argv)
{
    return sluice::run(argc, argv, take_part);
}

}  // namespace liggghts
