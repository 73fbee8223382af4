#include "participants/liggghts/drive.hpp"

#include <algorithm>
#include <utility>

namespace liggghts {
namespace {

using dem::Load;
using dem::Vec;

//! Adds the load times `factor` to what acts on a row of LIGGGHTS.
template <int D>
void add(Rows const& rows, int i, Load<D> const& load, double factor)
{
    double *f = rows.force[i], *t = rows.torque[i];
    f[0] += factor * load.force.x;
    f[1] += factor * load.force.y;
    if constexpr (D == 2) {
        t[2] += factor * load.torque;
    } else {
        f[2] += factor * load.force.z;
        t[0] += factor * load.torque.x;
        t[1] += factor * load.torque.y;
        t[2] += factor * load.torque.z;
    }
}

//! What a load does to a row, as it moves [W].
template <int D>
double power_of(Rows const& rows, int i, Load<D> const& load)
{
    double const *v = rows.velocity[i], *w = rows.spin[i];
    if constexpr (D == 2)
        return load.force.x * v[0] + load.force.y * v[1] + load.torque * w[2];
    else
        return load.force.x * v[0] + load.force.y * v[1] + load.force.z * v[2] + load.torque.x * w[0] +
               load.torque.y * w[1] + load.torque.z * w[2];
}

template <int D>
Load<D> mean_of(Load<D> const& a, Load<D> const& b)
{
    return {0.5 * (a.force + b.force), 0.5 * (a.torque + b.torque)};
}

//! The load of a row's grain; null: it has none.
template <int D>
Load<D> const* of(Rows const& rows, int i, std::vector<Load<D>> const& loads)
{
    auto const tag = static_cast<std::size_t>(rows.tag[i]);
    return tag < loads.size() ? &loads[tag] : nullptr;
}

}  // namespace

template <int D>
void Drive<D>::begin(Loads applied)
{
    applied_ = std::move(applied);
    engine_.couple([this](Rows const& rows) { push(rows); });
}

//! In every evaluation of forces. Velocities are those of the half step: what they and the load make is its work.
template <int D>
void Drive<D>::push(Rows const& rows)
{
    if (running_) {
        for (int i = 0; i < rows.count; ++i)
            if (auto const* load = of<D>(rows, i, now_)) {
                given_.impulse += dt_ * load->force;
                given_.work += dt_ * power_of<D>(rows, i, *load);
            }
        if (vary_ && ++step_ < steps_) {
            Loads const& next = load_(step_);
            applied_.resize(next.size());
            now_.resize(next.size());
            for (std::size_t k = 0; k < next.size(); ++k) applied_[k] = mean_of<D>(now_[k], next[k]);
            now_ = next;
        } else if (vary_) {
            applied_ = now_;
        }
    }
    for (int i = 0; i < rows.count; ++i)
        if (auto const* load = of<D>(rows, i, applied_)) add<D>(rows, i, *load, 1.0);
}

//! Other loads act at once, in the first half kick of the step that follows.
template <int D>
void Drive<D>::exchange(Loads const& with)
{
    Rows const rows = engine_.rows();
    for (int i = 0; i < rows.count; ++i) {
        if (auto const* load = of<D>(rows, i, applied_)) add<D>(rows, i, *load, -1.0);
        if (auto const* load = of<D>(rows, i, with)) add<D>(rows, i, *load, 1.0);
    }
    applied_ = with;
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
    now_ = load(0);
    exchange(now_);
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
