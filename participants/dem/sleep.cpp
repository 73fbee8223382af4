#include "participants/dem/sleep.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "participants/dem/neighbours.hpp"

namespace dem {
namespace {

//! One entry of one of two lists.
template <int D>
void append(Pairs<D> const& from, std::size_t slot, Pairs<D>& to)
{
    to.other.push_back(from.other[slot]);
    to.sqrt_mass.push_back(from.sqrt_mass[slot]);
    if (!from.image.empty()) to.image.push_back(from.image[slot]);
    each_array(from.history, to.history, [&](auto const& had, auto& has) { has.push_back(had[slot]); });
}

template <int D>
void end_row(Pairs<D>& pairs)
{
    pairs.first.push_back(static_cast<std::uint32_t>(pairs.other.size()));
}

//! Whether a force has changed by more than a hundredth of the weight, or, without weight, at all.
template <int D>
bool has_changed(Load<D> const& now, Load<D> const& then, double weight)
{
    return norm(now.force - then.force) > 0.01 * weight;
}

//! Grains that are too fast to sleep, or were so lately.
template <int D>
std::vector<bool> restless_grains(Setup<D> const& setup, State<D>& state)
{
    Grains<D> const& g = state.grains;
    double const most = setup.sleep.speed * setup.sleep.speed;
    std::vector<bool> restless(g.size());
    for (std::size_t i = 0; i < g.size(); ++i) {
        auto const& [velocity, spin] = g.motion[i];
        double const radius = g.place[i].radius;
        if (!(dot(velocity, velocity) + radius * radius * dot(spin, spin) <= most))
            state.rest.slow_since[i] = state.time;
        restless[i] = state.time - state.rest.slow_since[i] < setup.sleep.time;
    }
    return restless;
}

//! Those that have a restless grain or a wall that moves in their list: it may touch them before the next look. And
//! those whose load has changed since they fell asleep.
template <int D>
std::vector<bool> disturbed_grains(Setup<D> const& setup, State<D> const& state, std::vector<bool> const& restless)
{
    Grains<D> const& g = state.grains;
    std::vector<bool> disturbed(g.size());
    for (std::size_t i = 0; i < g.size(); ++i)
        for (std::uint32_t slot = state.pairs.first[i]; slot < state.pairs.first[i + 1]; ++slot) {
            std::size_t const j = state.pairs.other[slot];
            if (restless[i] != restless[j]) disturbed[restless[i] ? j : i] = true;
        }
    for (std::size_t w = 0; w < setup.walls.size(); ++w)
        if (setup.walls[w].motion.moves())
            for (std::uint32_t const i : state.walls[w].grain) disturbed[i] = true;
    if (!setup.loads) return disturbed;
    double const gravity = norm(setup.gravity);
    for (std::size_t i = 0; i < g.size(); ++i)
        if (state.rest.asleep[i] && has_changed(g.external[i], state.rest.load[i], g.mass[i] * gravity))
            disturbed[i] = true;
    return disturbed;
}

}  // namespace

template <int D>
void wake_all(State<D>& state)
{
    std::fill(state.rest.asleep.begin(), state.rest.asleep.end(), 0U);
    std::fill(state.rest.slow_since.begin(), state.rest.slow_since.end(), state.time);
}

template <int D>
Look look_for_sleepers(Setup<D> const& setup, State<D>& state)
{
    Grains<D>& g = state.grains;
    Rest<D>& rest = state.rest;
    if (rest.asleep.empty()) {
        rest.asleep.assign(g.size(), 0U);
        rest.slow_since.assign(g.size(), state.time);
        rest.load.assign(g.size(), Load<D>{});
    }
    auto const restless = restless_grains(setup, state);
    auto const disturbed = disturbed_grains(setup, state, restless);
    bool woke = false, slept = false;
    for (std::size_t i = 0; i < g.size(); ++i) {
        bool const sleeps = !restless[i] && !disturbed[i];
        if (sleeps == (rest.asleep[i] != 0U)) continue;
        rest.asleep[i] = sleeps ? 1U : 0U;
        (sleeps ? slept : woke) = true;
        if (!sleeps) {
            rest.slow_since[i] = state.time;
            continue;
        }
        if (setup.features.ledger)
            state.booked.removed_walls += 0.5 * (g.mass[i] * dot(g.motion[i].velocity, g.motion[i].velocity) +
                                                 g.inertia[i] * dot(g.motion[i].spin, g.motion[i].spin));
        g.motion[i] = g.half[i] = Motion<D>{};
        rest.load[i] = g.external[i];
    }
    if (woke || slept) take_back(setup, state);
    return woke ? Look::some_woke : slept ? Look::some_slept : Look::no_change;
}

template <int D>
void put_aside(Setup<D> const& setup, State<D>& state)
{
    Rest<D>& rest = state.rest;
    auto const& asleep = rest.asleep;
    if (std::none_of(asleep.begin(), asleep.end(), [](auto sleeps) { return sleeps != 0U; })) return;
    Pairs<D> const whole = std::move(state.pairs);
    Pairs<D> computed, left;
    computed.first = left.first = {0};
    for (std::size_t i = 0; i < asleep.size(); ++i) {
        for (std::uint32_t slot = whole.first[i]; slot < whole.first[i + 1]; ++slot)
            append(whole, slot, asleep[i] != 0U && asleep[whole.other[slot]] != 0U ? left : computed);
        end_row(computed);
        end_row(left);
    }
    derive_from_list(setup, computed, asleep.size());
    state.pairs = std::move(computed);
    rest.pairs = std::move(left);
}

template <int D>
void take_back(Setup<D> const& setup, State<D>& state)
{
    Rest<D>& rest = state.rest;
    if (!rest.is_apart()) return;
    Pairs<D> const computed = std::move(state.pairs), left = std::move(rest.pairs);
    Pairs<D> whole;
    whole.first = {0};
    for (std::size_t i = 0; i < rest.asleep.size(); ++i) {
        std::uint32_t a = computed.first[i], b = left.first[i];
        std::uint32_t const end_a = computed.first[i + 1], end_b = left.first[i + 1];
        while (a < end_a || b < end_b) {  // both rows ascend
            bool const from_left = a == end_a || (b < end_b && left.other[b] < computed.other[a]);
            append(from_left ? left : computed, from_left ? b++ : a++, whole);
        }
        end_row(whole);
    }
    derive_from_list(setup, whole, rest.asleep.size());
    state.pairs = std::move(whole);
    rest.pairs = {};
}

template Look look_for_sleepers<2>(Setup<2> const&, State<2>&);
template Look look_for_sleepers<3>(Setup<3> const&, State<3>&);
template void wake_all<2>(State<2>&);
template void wake_all<3>(State<3>&);
template void put_aside<2>(Setup<2> const&, State<2>&);
template void put_aside<3>(Setup<3> const&, State<3>&);
template void take_back<2>(Setup<2> const&, State<2>&);
template void take_back<3>(Setup<3> const&, State<3>&);

}  // namespace dem
