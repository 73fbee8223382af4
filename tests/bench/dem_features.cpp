#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <string>

#include "participants/dem/measures.hpp"
#include "participants/dem/setup.hpp"
#include "tests/bench/dem_column.hpp"
#include "tests/support/liggghts_column.hpp"

namespace dem_bench {
namespace {

using Setup = dem::Setup<3>;

void set_law(Setup& s, dem::ContactConfig const& law)
{
    s.law = dem::contact_law(law);
    for (auto& wall : s.walls) wall.law = s.law;
    s.features.elasticity = law.elasticity;
    s.features.friction = law.friction > 0.0;
    s.features.rolling = law.rolling;
}

//! Linear contacts with friction and nothing else; the column's floor and four sides.
Setup base(double side)
{
    Setup s = liggghts::setup(side);
    s.absolute_damping = false;
    s.features = {.friction = true};
    set_law(s, laws());
    return s;
}

//! As stiff as the linear contacts are at an overlap of 1 % of the radius.
dem::ContactConfig hertz()
{
    auto c = laws();
    c.elasticity = dem::Elasticity::hertz;
    c.youngs_modulus = liggghts::kn / (mean_radius * std::sqrt(0.5 * 0.01) * 2.0 / 3.0);
    c.poissons_ratio = 0.25;
    return c;
}

void between_periodic_sides(Setup& s, double side)
{
    s.walls.resize(1);  // the floor
    s.periodic.axis = {true, true, false};
    s.periodic.extent = {side, side, 0.0};
    s.features.periodic = true;
}

struct Feature
{
    char const* name;
    std::function<void(Setup&)> turn_on;
};

std::vector<Feature> all_features(double side)
{
    return {{"linear contacts with friction: the step all others stand against", [](Setup&) {}},
            {"without friction",
             [](Setup& s) {
                 auto c = laws();
                 c.friction = 0.0;
                 set_law(s, c);
             }},
            {"rolling: constant", [](Setup& s) { set_law(s, laws(dem::Rolling::constant)); }},
            {"rolling: elastic_plastic", [](Setup& s) { set_law(s, laws(dem::Rolling::elastic_plastic)); }},
            {"law: hertz", [](Setup& s) { set_law(s, hertz()); }},
            {"a partner's loads", [](Setup& s) { s.loads = true; }},
            {"walls that move",
             [](Setup& s) {
                 s.walls[0].motion.amplitude = {1e-6, 0.0, 0.0};
                 s.walls[0].motion.frequency = 50.0;
             }},
            {"gravity that grows", [](Setup& s) { s.gravity_ramp = 1e3, s.first_gravity = s.gravity; }},
            {"a frame that rotates",
             [](Setup& s) {
                 s.frame.emplace(sluice::Rotation{{0, 0, 2}, {0, 1, 0}, 0.1, 0, true, true, true});
             }},
            {"periodic sides", [side](Setup& s) { between_periodic_sides(s, side); }},
            {"energy ledger", [](Setup& s) { s.features.ledger = true; }},
            {"pairs one at a time (the oracle)", [](Setup& s) { s.plain = true; }}};
}

//! Best rate of a[i] = b[i] + s c[i] over arrays far larger than the caches [B/s].
double bandwidth()
{
    std::size_t const n = std::size_t{1} << 23;
    std::vector<double> a(n, 1.0), b(n, 2.0), c(n, 3.0);
    double best = 0.0;
    for (int repeat = 0; repeat < 5; ++repeat) {
        double const start = wall_time();
        for (std::size_t i = 0; i < n; ++i) a[i] = b[i] + 1.0001 * c[i];
        best = std::max(best, 3.0 * sizeof(double) * static_cast<double>(n) / (wall_time() - start));
    }
    if (a[n / 2] == 0.0) std::printf("\n");  // somebody looks at it
    return best;
}

//! Best rate of additions and products of doubles from registers [1/s]: eight sums of four that do not wait for each
//! other.
double arithmetic()
{
    using Four = double __attribute__((vector_size(32)));
    Four sum[8], factor = {1.0000001, 0.9999999, 1.0000002, 0.9999998};
    for (auto& s : sum) s = factor;
    constexpr int rounds = 4'000'000;
    double best = 0.0;
    for (int repeat = 0; repeat < 3; ++repeat) {
        double const start = wall_time();
        for (int k = 0; k < rounds; ++k)
            for (auto& s : sum) s = s * factor + factor;
        best = std::max(best, 2.0 * 4.0 * 8.0 * rounds / (wall_time() - start));
    }
    for (auto const& s : sum)
        if (s[0] == 0.0) std::printf("\n");
    return best;
}

//! What a step must at least move and reckon. Per pair in the list: its two indices, mark, sqrt(m*) and, touching, the
//! spring read and written; per grain: what drift, contacts and kick read and write of places, motions and loads once
//! each. Per contact about 160 operations (counted in packed_contacts.hpp: kinematics 60, laws 55, loads 45), its two
//! quotients and two roots as one each.
void limits(std::size_t count, double seconds_per_step, std::size_t contacts, std::size_t listed)
{
    double const per_grain = 2.0 * sizeof(dem::Place<3>) + 6.0 * sizeof(dem::Motion<3>) + 3.0 * sizeof(dem::Load<3>);
    double const n = static_cast<double>(count), touching = static_cast<double>(contacts);
    double const bytes = n * per_grain + 17.0 * static_cast<double>(listed) + 48.0 * touching;
    double const by_memory = bandwidth() / bytes * touching, by_arithmetic = arithmetic() / 160.0;
    double const rate = touching / seconds_per_step;
    std::printf(
        "%7zu grains  %.1f ns a contact, %.1f million contacts/s (%.2f contacts and %.2f listed pairs a grain)\n",
        count, 1e9 / rate, 1e-6 * rate, touching / n, static_cast<double>(listed) / n);
    std::printf(
        "%7zu grains  limits, million contacts/s: memory %.0f (if nothing stayed in cache), arithmetic %.0f: "
        "%.0f %% of the nearer\n",
        count, 1e-6 * by_memory, 1e-6 * by_arithmetic, 100.0 * rate / std::min(by_memory, by_arithmetic));
    auto const name = std::to_string(count) + " grains, contacts";
    note(name, "time", 1e9 / rate, "ns", "memory", rate / by_memory);
    note(name, "time", 1e9 / rate, "ns", "arithmetic", rate / by_arithmetic);
}

//! What a step asks about features that are off, once and not for each grain: a step of no grains.
double step_of_nothing(Setup const& setup)
{
    dem::Solver<3> solver(setup, {});
    constexpr int steps = 20000;
    double const start = own_time();
    solver.steps(liggghts::step, steps);
    return (own_time() - start) / steps;
}

}  // namespace

void features(std::size_t count, int steps, int repetitions)
{
    double const side = side_of(count);
    auto const grains = settled(count);
    auto const all = all_features(side);
    std::vector<std::vector<double>> times(all.size());
    std::vector<dem::Solver<3>> solvers;
    for (auto const& feature : all) {
        Setup s = base(side);
        feature.turn_on(s);
        solvers.emplace_back(s, grains);
    }
    for (int r = 0; r < repetitions; ++r)
        for (std::size_t k = 0; k < all.size(); ++k) times[k].push_back(run_ours(solvers[k], steps, own_time) / steps);
    for (std::size_t k = 0; k < all.size(); ++k) {
        std::vector<double> ratio;
        for (std::size_t r = 0; r < times[k].size(); ++r) ratio.push_back(times[k][r] / times[0][r]);
        auto const [low, high] = std::minmax_element(ratio.begin(), ratio.end());
        std::printf("%7zu grains  %-66s %8.1f us a step, %.2f x (%.2f to %.2f)\n", count, all[k].name,
                    1e6 * median(times[k]), median(ratio), *low, *high);
        note(std::to_string(count) + " grains, " + all[k].name, "time of a step", 1e6 * median(times[k]), "us",
             all[0].name, median(ratio));
    }
    double const step = median(times[0]), nothing = step_of_nothing(base(side));
    std::printf("%7zu grains  all features that are off: %.2f us a step, %.3f %% of it; what is off is not in a loop\n",
                count, 1e6 * nothing, 100.0 * nothing / step);
    note(std::to_string(count) + " grains, features that are off", "time of a step", 1e6 * nothing, "us", all[0].name,
         nothing / step);
    limits(count, step, static_cast<std::size_t>(dem::measure(solvers[0]).contacts),
           solvers[0].state().pairs.other.size());
    std::fflush(stdout);
}

}  // namespace dem_bench
