#include "participants/liggghts/drive.hpp"

#include <utility>

namespace liggghts {
namespace {

std::array<double, 3> sum_of(std::vector<double> const& force)
{
    std::array<double, 3> sum{};
    for (std::size_t n = 0; n < force.size(); n += 3)
        for (std::size_t k = 0; k < 3; ++k) sum[k] += force[n + k];
    return sum;
}

}  // namespace

void Drive::begin(Loads applied, Wanted const& wanted)
{
    applied_ = std::move(applied);
    wanted_ = wanted;
    engine_.couple([this](Rows const& rows) { push(rows); });
}

//! In every evaluation of forces. Velocities are those of the half step: what they and the load make is its work.
void Drive::push(Rows const& rows)
{
    if (running_ && wanted_.work) given_.work += dt_ * (vary_ ? now_ : applied_).power(rows);
    if (running_ && vary_) turn_to_next();
    applied_.add_to(rows);
}

void Drive::book_impulse(double seconds, Loads const& loads)
{
    if (!wanted_.impulse) return;
    auto const sum = sum_of(loads.force);
    for (std::size_t k = 0; k < sum.size(); ++k) given_.impulse[k] += seconds * sum[k];
}

//! The step in progress ends: with the mean of its load and the next one's, after the last step with its own.
void Drive::turn_to_next()
{
    if (++step_ == steps_) {
        applied_ = now_;
        return;
    }
    load_(step_, next_);
    applied_.set_mean(now_, next_);
    std::swap(now_, next_);
    book_impulse(dt_, now_);
}

Given Drive::advance(std::int64_t steps, double dt, LoadOfStep const& load, bool vary,
                     std::vector<Removal> const& removals)
{
    given_ = {};
    load_ = load;
    vary_ = vary;
    step_ = 0;
    steps_ = steps;
    dt_ = dt;
    load(0, now_);
    book_impulse((vary ? 1.0 : static_cast<double>(steps)) * dt, now_);
    // it acts at once, in the first half kick, for what acted before
    now_.replace(engine_.rows(), applied_);
    if (vary)
        applied_ = now_;
    else
        std::swap(applied_, now_);
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

}  // namespace liggghts
