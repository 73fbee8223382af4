// Energy by the ledger: power point by point, loads that reach other points, several processes, solvers that read less.
#include "coupler/work.hpp"

#include <doctest/doctest.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>
#include <random>

#include "coupler/channel.hpp"
#include "tests/support/run_in_threads.hpp"

namespace {

using sluice::FramePart;
using sluice::KeptPoints;

std::vector<double> random_numbers(std::size_t count, unsigned seed)
{
    std::mt19937 generator(seed);
    std::uniform_real_distribution<double> any(-1, 1);
    std::vector<double> numbers(count);
    for (double& x : numbers) x = any(generator);
    return numbers;
}

KeptPoints points(std::vector<std::int64_t> const& ids, std::vector<double> const& numbers)
{
    return {0, ids, {numbers}};
}

//! The same points and numbers in another order.
KeptPoints shuffled(KeptPoints const& from, std::size_t width, unsigned seed)
{
    std::vector<std::size_t> order(from.ids.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::shuffle(order.begin(), order.end(), std::mt19937(seed));
    KeptPoints to = from;
    for (std::size_t i = 0; i < order.size(); ++i) {
        to.ids[i] = from.ids[order[i]];
        for (std::size_t k = 0; k < width; ++k) to.columns[0][i * width + k] = from.columns[0][order[i] * width + k];
    }
    return to;
}

double power(KeptPoints const& load, KeptPoints const& motion, std::size_t width)
{
    FramePart const l{load.view(), 1}, m{motion.view(), 1};
    return sluice::power_of(0, 0, width, {&l, 1}, {&m, 1}).net;
}

// ---- a run: grains that move in circles, and a fluid that drags them

constexpr int grains = 30;

double speed(std::int64_t id, int axis, double t)
{
    return std::sin(t + 0.3 * static_cast<double>(id) + axis);
}

//! What goes wrong on purpose, and how the two read their edges.
struct Manner
{
    int samples = 3;
    bool no_torque = false;    //!< the grains do not read it
    bool reversed = false;     //!< the fluid writes its loads in the opposite order
    bool come_and_go = false;  //!< some grains are there in every second window only
    int grain_ranks = 1, water_ranks = 1;
};

std::vector<std::int64_t> ids_of(int rank, int ranks, std::int64_t window, bool come_and_go)
{
    std::vector<std::int64_t> ids;
    for (std::int64_t i = 0; i < grains; ++i)
        if ((i + window) % ranks == rank && !(come_and_go && i % 5 == 0 && window % 2 == 0)) ids.push_back(i);
    return ids;
}

in_threads::Solve grains_of(int rank, Manner const& manner)
{
    return [=](sluice::Participant& self) {
        self.config().finish();
        if (manner.no_torque) self.reads("load", {"force"});
        auto tell = [&](std::int64_t window, double t) {
            auto const ids = ids_of(rank, manner.grain_ranks, window, manner.come_and_go);
            std::vector<double> place, velocity, spin, radius(ids.size(), 0.1);
            for (auto const id : ids) {
                place.insert(place.end(), {static_cast<double>(id), 0.5});
                velocity.insert(velocity.end(), {speed(id, 0, t), speed(id, 1, t)});
                spin.push_back(speed(id, 2, t));
            }
            self.write("water", sluice::Kinematics{ids, place, velocity, spin, radius});
        };
        tell(0, 0);
        for (sluice::Window const& window : self.windows()) {
            auto load = self.read<sluice::Load>("water", window);
            for (int k = 0; k < manner.samples; ++k) load.at(window.begin + (k + 0.5) * window.length / manner.samples);
            tell(window.index + 1, window.end);
        }
    };
}

//! One of several processes that share all points: each gives its part of the drag.
in_threads::Solve water(int rank, Manner const& manner)
{
    return [=](sluice::Participant& self) {
        self.config().finish();
        double const edge = static_cast<double>(grains) / manner.water_ranks;
        self.covers({{rank * edge - 0.5, 0, 0}, {(rank + 1) * edge - 0.5, 1, 0}});
        self.write("grains", sluice::Load{});
        for (sluice::Window const& window : self.windows()) {
            auto kinematics = self.read<sluice::Kinematics>("grains", window);
            std::vector<std::int64_t> ids;
            std::vector<double> force, torque;
            for (int k = 0; k < manner.samples; ++k) {
                auto const now = kinematics.at(window.begin + (k + 0.5) * window.length / manner.samples);
                ids.assign(now.id.begin(), now.id.end());
                force.resize(2 * ids.size());
                torque.resize(ids.size());
                for (std::size_t i = 0; i < force.size(); ++i) force[i] = 3 - now.velocity[i];
                for (std::size_t i = 0; i < torque.size(); ++i) torque[i] = -2 * now.angular_velocity[i];
            }
            if (manner.reversed) {
                std::reverse(ids.begin(), ids.end());
                std::reverse(torque.begin(), torque.end());
                for (std::size_t i = 0; i < ids.size() / 2; ++i)
                    std::swap_ranges(force.begin() + static_cast<std::ptrdiff_t>(2 * i),
                                     force.begin() + static_cast<std::ptrdiff_t>(2 * i + 2),
                                     force.end() - static_cast<std::ptrdiff_t>(2 * i + 2));
            }
            self.write("grains", sluice::Load{ids, force, torque});
        }
    };
}

struct Ran
{
    in_threads::Outcome outcome;
    std::vector<nlohmann::json> energy;  //!< per process of the grains
    std::string warnings;
};

Ran run(Manner const& manner, std::string const& forth, std::string const& back, int windows = 40,
        std::string const& ledger = "{energy: {every: 1, tolerance: 100}}")
{
    auto const scene = fmt::format(R"(sluice: 1
time: {{end: {}, window: 0.1}}
ledger: {}
participants: {{grains: {{command: none, ranks: {}}}, water: {{command: none, ranks: {}}}}}
couplings:
  - {{from: grains, to: water, data: kinematics, {}}}
  - {{from: water, to: grains, data: load, {}}}
)",
                                   0.1 * windows, ledger, manner.grain_ranks, manner.water_ranks, forth, back);
    std::vector<std::pair<std::string, in_threads::Solve>> all;
    for (int r = 0; r < manner.grain_ranks; ++r) all.emplace_back(fmt::format("grains:{}", r), grains_of(r, manner));
    for (int r = 0; r < manner.water_ranks; ++r) all.emplace_back(fmt::format("water:{}", r), water(r, manner));
    in_threads::Scratch scratch;
    Ran ran{in_threads::run(scene, all, scratch.path()), {}, {}};
    for (int r = 0; r < manner.grain_ranks; ++r) {
        auto const name = manner.grain_ranks == 1 ? std::string("grains") : fmt::format("grains:{}", r);
        nlohmann::json summary;
        std::ifstream(scratch.path() / "run/.sluice" / (name + ".json")) >> summary;
        for (auto const& entry : summary.at("ledger"))
            if (entry.contains("energy")) ran.energy.push_back(entry.at("energy"));
        ran.warnings += summary.at("warnings").dump();
    }
    return ran;
}

void check_closed(Ran const& ran, int windows)
{
    for (auto const& error : ran.outcome.errors) CHECK(error == "");
    CHECK(ran.warnings.find("ledger") == std::string::npos);
    for (auto const& energy : ran.energy) {
        CHECK(energy.at("windows").get<int>() >= windows - 2);
        CHECK(energy.at("closes to").get<double>() < 1e-13);  // a few hundred products, each rounded
        CHECK(energy.at("moved [J]").get<double>() > 1);
    }
}

}  // namespace

TEST_CASE("work: power is the sum over points, whatever their order, in blocks and beyond")
{
    for (std::size_t const width : {1, 2, 3})
        for (std::size_t const n : {0, 1, 5, 170, 171, 512, 513, 5000}) {
            std::vector<std::int64_t> ids(n);
            std::iota(ids.begin(), ids.end(), 7);
            auto const f = random_numbers(n * width, 1), v = random_numbers(n * width, 2);
            double expected = 0;
            for (std::size_t k = 0; k < f.size(); ++k) expected += f[k] * v[k];
            auto const load = points(ids, f), motion = points(ids, v);
            double const rounding = 1e-16 * static_cast<double>(n * width) + 1e-300;
            CHECK(std::abs(power(load, motion, width) - expected) <= rounding);
            CHECK(std::abs(power(load, shuffled(motion, width, 3), width) - expected) <= rounding);
            CHECK(std::abs(power(shuffled(load, width, 4), motion, width) - expected) <= rounding);
        }
}

TEST_CASE("work: a mean over frames, and points that one of them lacks or that nobody knows")
{
    auto const load = points({1, 2, 3}, {10, 20, 30});
    auto const now = points({1, 2}, {1, 2}), before = points({2, 1}, {4, 3}), older = points({3, 1}, {5, 7});
    FramePart const loads[] = {{load.view(), 1}};
    FramePart const both[] = {{now.view(), 0.5}, {before.view(), 0.5}};
    CHECK(sluice::power_of(0, 0, 1, loads, both).net == 10 * 2 + 20 * 3);  // nobody moves 3
    FramePart const with_older[] = {{now.view(), 0.5}, {older.view(), 0.5}};
    // 2 moves as it does now, 3 as it did
    CHECK(sluice::power_of(0, 0, 1, loads, with_older).net == 10 * 4 + 20 * 2 + 30 * 5);
    CHECK(sluice::power_of(0, 0, 1, loads, with_older).moved == 10 * 4 + 20 * 2 + 30 * 5);
}

TEST_CASE("work: which columns make power")
{
    auto const& all = sluice::vocabulary();  // kinematics, load, phase, body_force
    auto const pairs = sluice::power_pairs(all[1], all[0], 3);
    REQUIRE(pairs.size() == 2);
    CHECK(pairs[0].label == "force x velocity");
    CHECK(pairs[1].label == "torque x angular_velocity");
    CHECK(sluice::power_pairs(all[1], all[2], 3).size() == 1);
    CHECK(sluice::power_pairs(all[3], all[2], 2).size() == 1);
    CHECK(sluice::power_pairs(all[0], all[1], 3).empty());
    sluice::DataSpec const scalar{"s", {{"speed", sluice::Shape::scalar, "m/s"}}, false, false};
    CHECK(sluice::power_pairs(all[1], scalar, 2).empty());  // a force has two numbers there
}

TEST_CASE("work: closes to rounding for every scheme, order of points and number of processes")
{
    for (std::string const forth : {"lag: 0", "lag: 0, sample: hold", "lag: 1", "lag: 1, predict: quadratic"})
        for (std::string const back : {"lag: 1", "lag: 1, predict: linear", "lag: 1, predict: quadratic",
                                       "lag: 1, predict: linear, sample: hold", "lag: 0"}) {
            if (forth.starts_with("lag: 0") && back == "lag: 0") continue;
            CAPTURE(forth);
            CAPTURE(back);
            for (int const kind : {0, 1, 2, 3}) {
                CAPTURE(kind);
                check_closed(
                    run({.samples = kind == 3 ? 1 : 3, .reversed = kind == 1, .come_and_go = kind == 2}, forth, back),
                    40);
            }
        }
    for (int const m : {1, 2, 3})
        for (int const n : {1, 2}) {
            CAPTURE(m);
            CAPTURE(n);
            check_closed(run({.grain_ranks = m, .water_ranks = n}, "lag: 0", "lag: 1, predict: linear"), 40);
        }
}

TEST_CASE("work: a column that the receiver does not read is no part of it")
{
    Manner const all{}, fewer{.no_torque = true};
    auto const with = run(all, "lag: 0", "lag: 1"), without = run(fewer, "lag: 0", "lag: 1");
    check_closed(with, 40);
    check_closed(without, 40);
    double const force_and_torque = with.energy.at(0).at("given [J]"), force = without.energy.at(0).at("given [J]");
    // torque -2 w gives at each window -2 w^2, w a sine: about -grains windows 0.1 s
    CHECK(std::abs(force_and_torque - force + grains * 40 * 0.1) < 0.3 * grains * 40 * 0.1);
}

TEST_CASE("work: one window in so many is looked at, and none where the scene says so")
{
    Manner const plain{};
    auto const some = run(plain, "lag: 0", "lag: 1", 40, "{energy: {every: 7}}");
    REQUIRE(some.energy.size() == 1);
    CHECK(some.energy[0].at("windows") == 5);  // 6, 13, 20, 27, 34
    CHECK(run(plain, "lag: 0", "lag: 1", 40, "{energy: {every: 0}}").energy.empty());
    CHECK(run(plain, "lag: 0", "lag: 1", 40, "{}").energy.at(0).at("windows") == 0);  // 199 is beyond the end
}

TEST_CASE("work: goes on after a checkpoint, from the window for which both ends of the motion are known")
{
    auto const side = [](std::string const& partner, std::string const& says, std::string const& hears, double sign) {
        return [=](sluice::Participant& self) {
            self.config().finish();
            double x = 1;
            self.keeps([&](sluice::State& s) { s.put_number("x", x); },
                       [&](sluice::State const& s) { x = s.number("x"); });
            std::int64_t const id[] = {7};
            auto tell = [&] { self.write(partner, says, id, {std::span(&x, 1)}); };
            if (!self.resumes()) tell();
            for (sluice::Window const& window : self.windows()) {
                x += sign * window.length * self.read(partner, hears, window).columns(window.end)[0][0];
                tell();
            }
        };
    };
    for (std::string const terms : {"lag: 0", "lag: 1, predict: linear"}) {
        CAPTURE(terms);
        std::string const scene = R"(sluice: 1
time: {end: 2.5, window: 0.1}
ledger: {energy: {every: 1, tolerance: 10}}
checkpoint: {windows: 10}
data: {motion: {columns: {velocity: {unit: m/s}}}, force: {columns: {force: {unit: N}}}}
participants: {mass: {command: none}, spring: {command: none}}
couplings:
  - {from: mass, to: spring, data: motion, )" +
                                  terms +
                                  R"(}
  - {from: spring, to: mass, data: force, lag: 1, predict: linear}
)";
        in_threads::Scratch scratch;
        std::vector<std::pair<std::string, in_threads::Solve>> const both{
            {"mass", side("spring", "motion", "force", 1)}, {"spring", side("mass", "force", "motion", -1)}};
        for (bool const resume : {false, true}) {
            auto const outcome =
                in_threads::run(scene, both, scratch.path(),
                                resume ? std::vector<std::string>{"time.end=4"} : std::vector<std::string>{}, resume);
            for (auto const& error : outcome.errors) CHECK(error == "");
            nlohmann::json summary;
            std::ifstream(scratch.path() / "run/.sluice/mass.json") >> summary;
            CHECK(summary.at("warnings").empty());
            auto const& energy = summary.at("ledger").at(0).at("energy");
            // windows 0 to 23, and 21 to 38 after the checkpoint before window 20: the last force is not waited for
            CHECK(energy.at("windows") == (resume ? 18 : 24));
            CHECK(energy.at("closes to").get<double>() < 1e-13);
        }
    }
}

TEST_CASE("work: loads that reach other points than they were made for have the right sum and are found")
{
    // the bytes of a sender that mixed up two ids, as a wrong table of places would: sums and hashes are right
    sluice::DataSpec const spec = sluice::vocabulary()[1];
    sluice::WorkAccount account("water -> grains: load");
    std::vector<std::int64_t> const ids{1, 2, 3};
    auto const force = points(ids, {1, 0, 2, 0, 3, 0}), velocity = points(ids, {1, 0, 1.5, 0, -1, 0});
    auto wrong = force;
    std::swap(wrong.ids[0], wrong.ids[2]);
    std::vector<std::span<double const>> const columns{force.columns[0], {}};
    CHECK(sluice::totals_of(spec, 2, columns) ==
          sluice::totals_of(spec, 2, {std::span<double const>(wrong.columns[0]), {}}));
    double const sent = power(force, velocity, 2), received = power(wrong, velocity, 2);
    account.same(3, "sent", sent, "received", sent, 7);
    CHECK(account.violation(1e-9) == "");
    account.same(4, "sent", sent, "received", received, 7);
    auto const text = account.violation(1e-9);
    CHECK(text.find("water -> grains: load: energy does not close: in window 4 sent 1 W, received 5 W") !=
          std::string::npos);
}

TEST_CASE("work: staggering is judged after enough windows, and a pair that one side does not know is left out")
{
    sluice::WorkAccount account("a -> b: load");
    double const unknown = std::nan("");
    for (int n = 0; n < 30; ++n) {
        account.given(n, {1.0, unknown});
        account.taken(n, {{1.5, 1.5}, {100, 100}}, 2.0);
        CHECK((account.excess(0.3) != "") == (n >= 19));
        CHECK(account.excess(0.4) == "");
    }
    auto const s = account.summary();
    CHECK(s.at("given [J]") == 60);
    CHECK(s.at("taken [J]") == 90);
    CHECK(s.at("made [J]") == 30);
}
