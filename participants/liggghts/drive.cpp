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

}  // namespace

template <int D>
void Drive<D>::begin(Loads applied, bool work)
{
    applied_ = std::move(applied);
    wants_work_ = work;
    engine_.couple([this](Rows const& rows) { push(rows); });
}

//! In every evaluation of forces. Velocities are those of the half step: what they and the load make is its work.
template <int D>
void Drive<D>::push(Rows const& rows)
{
    if (running_ && wants_work_)
        for (int i = 0; i < rows.count; ++i)
            if (auto const* load = of<D>(rows, i, vary_ ? now_ : applied_))
                given_.work += dt_ * power_of<D>(rows, i, *load);
    if (running_ && vary_) turn_to_next();
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
    given_.impulse += dt_ * sum_of<D>(now_);
}

//! The loads of the first step act at once, in its first half kick, for what acted before.
template <int D>
void Drive<D>::exchange()
{
    Rows const rows = engine_.rows();
    static constexpr Acting<D> none{};
    for (int i = 0; i < rows.count; ++i) {
        auto const *was = of<D>(rows, i, applied_), *is = of<D>(rows, i, now_);
        if (!was && !is) continue;
        Acting<D> change = is ? *is : none;
        for (std::size_t k = 0; was && k < change.size(); ++k) change[k] -= (*was)[k];
        add<D>(rows, i, change);
    }
    if (vary_)
        applied_ = now_;
    else
        applied_.swap(now_);
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
    given_.impulse = (vary ? 1.0 : static_cast<double>(steps)) * dt * sum_of<D>(now_);
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

template class Drive<2>;
template class Drive<3>;

}  // namespace liggghts
