#include "participants/liggghts/drive.hpp"

#include <algorithm>
#include <utility>

namespace liggghts {
namespace {

//! Adds a load to what acts on a row of LIGGGHTS.
template <int D>
void add(Rows const& rows, int i, Acting<D> const& load)
{
    double *f = rows.force[i], *t = rows.torque[i];
    for (std::size_t k = 0; k < D; ++k) f[k] += load[k];
    if constexpr (D == 2)
        t[2] += load[2];
    else
        for (std::size_t k = 0; k < 3; ++k) t[k] += load[3 + k];
}

//! What a load does to a row, as it moves [W].
template <int D>
double power_of(Rows const& rows, int i, Acting<D> const& load)
{
    double const *v = rows.velocity[i], *w = rows.spin[i];
    double power = D == 2 ? load[2] * w[2] : 0.0;
    for (std::size_t k = 0; k < D; ++k) power += load[k] * v[k];
    if constexpr (D == 3)
        for (std::size_t k = 0; k < 3; ++k) power += load[3 + k] * w[k];
    return power;
}

template <int D>
dem::Vec<D> sum_of(std::vector<Acting<D>> const& loads)
{
    std::array<double, D> sum{};
    for (auto const& load : loads)
        for (std::size_t k = 0; k < D; ++k) sum[k] += load[k];
    if constexpr (D == 2)
        return {sum[0], sum[1]};
    else
        return {sum[0], sum[1], sum[2]};
}

//! The load of a row's grain; null: it has none.
template <int D>
Acting<D> const* of(Rows const& rows, int i, std::vector<Acting<D>> const& loads)
{
    auto const tag = static_cast<std::size_t>(rows.tag[i]);
    return tag < loads.size() ? &loads[tag] : nullptr;
}

//! The load of a row's grain, or that it has none.
template <int D>
Acting<D> const& of_or_none(Rows const& rows, int i, std::vector<Acting<D>> const& loads)
{
    static constexpr Acting<D> none{};
    auto const* const load = of<D>(rows, i, loads);
    return load ? *load : none;
}

}  // namespace

//! Calls `each(of force or torque, component, number)`; not a copy of three numbers by the library, which is a call.
template <int D, class Each>
void each_component(Acting<D> const& load, Each&& each)
{
    for (std::size_t k = 0; k < D; ++k) each(false, k, load[k]);
    if constexpr (D == 2)
        each(true, std::size_t{2}, load[2]);
    else
        for (std::size_t k = 0; k < 3; ++k) each(true, k, load[3 + k]);
}

template <int D>
void LoadsInRows<D>::set(std::size_t row, Acting<D> const& load)
{
    each_component<D>(
        load, [&](bool turns, std::size_t k, double number) { (turns ? torque_ : force_)[3 * row + k] = number; });
}

template <int D>
void LoadsInRows<D>::change(Rows const& rows, std::size_t row, Acting<D> const& load)
{
    each_component<D>(load, [&](bool turns, std::size_t k, double number) {
        double& kept = (turns ? torque_ : force_)[3 * row + k];
        (turns ? rows.torque : rows.force)[0][3 * row + k] += number - kept;
        kept = number;
    });
}

template <int D>
void LoadsInRows<D>::add_to(Rows const& rows) const
{
    if (rows.count == 0) return;
    double *f = rows.force[0], *t = rows.torque[0];  // LIGGGHTS has its rows one behind the other
    for (std::size_t k = 0; k < force_.size(); ++k) f[k] += force_[k];
    for (std::size_t k = 0; k < torque_.size(); ++k) t[k] += torque_[k];
}

template <int D>
void Drive<D>::begin(Loads applied, Wanted const& wanted)
{
    applied_ = std::move(applied);
    wanted_ = wanted;
    engine_.couple([this](Rows const& rows) { push(rows); });
}

//! In every evaluation of forces. Velocities are those of the half step: what they and the load make is its work.
template <int D>
void Drive<D>::push(Rows const& rows)
{
    if (running_ && wanted_.work)
        for (int i = 0; i < rows.count; ++i)
            if (auto const* load = of<D>(rows, i, vary_ ? now_ : applied_))
                given_.work += dt_ * power_of<D>(rows, i, *load);
    if (running_ && vary_) turn_to_next();
    add_applied(rows);
}

//! The loads that are applied, in the order of the rows.
template <int D>
void Drive<D>::follow(Rows const& rows)
{
    if (in_rows_.are_of(rows)) return;
    in_rows_.begin(rows);
    for (int i = 0; i < rows.count; ++i) in_rows_.set(static_cast<std::size_t>(i), of_or_none<D>(rows, i, applied_));
}

template <int D>
void Drive<D>::add_applied(Rows const& rows)
{
    if (!vary_) {
        follow(rows);
        return in_rows_.add_to(rows);
    }
    for (int i = 0; i < rows.count; ++i)
        if (auto const* load = of<D>(rows, i, applied_)) add<D>(rows, i, *load);
}

//! The step in progress ends: with the mean of its load and the next one's, after the last step with its own.
template <int D>
void Drive<D>::turn_to_next()
{
    if (++step_ == steps_) {
        applied_ = now_;
        return;
    }
    load_(step_, next_);
    now_.resize(next_.size());
    applied_.resize(next_.size());
    for (std::size_t n = 0; n < next_.size(); ++n)
        for (std::size_t k = 0; k < next_[n].size(); ++k) applied_[n][k] = 0.5 * (now_[n][k] + next_[n][k]);
    now_.swap(next_);
    if (wanted_.impulse) given_.impulse += dt_ * sum_of<D>(now_);
}

//! The loads of the first step act at once, in its first half kick, for what acted before.
template <int D>
void Drive<D>::exchange()
{
    Rows const rows = engine_.rows();
    if (!vary_) {
        follow(rows);
        for (int i = 0; i < rows.count; ++i)
            in_rows_.change(rows, static_cast<std::size_t>(i), of_or_none<D>(rows, i, now_));
        return applied_.swap(now_);
    }
    for (int i = 0; i < rows.count; ++i) {
        Acting<D> change = of_or_none<D>(rows, i, now_);
        auto const& was = of_or_none<D>(rows, i, applied_);
        for (std::size_t k = 0; k < change.size(); ++k) change[k] -= was[k];
        add<D>(rows, i, change);
    }
    applied_ = now_;
    in_rows_ = {};
}

template <int D>
Given<D> Drive<D>::advance(std::int64_t steps, double dt, LoadOfStep const& load, bool vary,
                           std::vector<Removal> const& removals)
{
    given_ = {};
    load_ = load;
    vary_ = vary;
    step_ = 0;
    steps_ = steps;
    dt_ = dt;
    load(0, now_);
    if (wanted_.impulse) given_.impulse = (vary ? 1.0 : static_cast<double>(steps)) * dt * sum_of<D>(now_);
    exchange();
    std::int64_t done = 0;
    auto const run_until = [&](std::int64_t step) {
        if (step == done) return;
        running_ = true;
        engine_.run(step - done, dt);
        running_ = false;
        done = step;
    };
    for (Removal const& removal : removals) {
        run_until(removal.step);
        engine_.command("unfix " + removal.fix, "removal of a wall");
        engine_.evaluate();
    }
    run_until(steps);
    return given_;
}

template class LoadsInRows<2>;
template class LoadsInRows<3>;
template class Drive<2>;
template class Drive<3>;

}  // namespace liggghts
