#include "coupler/schedule/schedule.hpp"

#include <algorithm>
#include <cassert>
#include <utility>

namespace sluice {

Schedule::Schedule(std::vector<InEdge> in, bool grouped, std::int64_t window)
    : in_(std::move(in)),
      arrived_(in_.size(), window == 0 ? 0 : window + 1),
      results_(in_.size(), 0),
      grouped_(grouped),
      window_(window),
      sent_(window > 0)
{
    assert(window >= 0);
}

Action Schedule::await(std::size_t edge, std::int64_t frame, std::uint32_t iteration) const
{
    return {.kind = Action::Kind::await,
            .window = window_,
            .frame = frame,
            .iteration = iteration,
            .edge = static_cast<int>(edge)};
}

Action Schedule::next() const
{
    if (!sent_) return {.kind = Action::Kind::send, .window = window_, .frame = window_};
    if (over_) return {.kind = Action::Kind::finish, .window = window_};
    if (!planned_) return {.kind = Action::Kind::plan, .window = window_};
    for (std::size_t e = 0; e < in_.size(); ++e)
        if (arrived_[e] <= window_) return await(e, arrived_[e], 0);
    if (plan_.checkpoint && !stored_) return {.kind = Action::Kind::checkpoint, .window = window_};
    if (plan_.stop) return {.kind = Action::Kind::finish, .window = window_};
    for (std::size_t e = 0; e < in_.size(); ++e) {
        if (in_[e].lag != 0) continue;
        if (!in_[e].inside && arrived_[e] <= window_ + 1) return await(e, window_ + 1, 0);
        if (in_[e].inside && results_[e] <= iteration_) return await(e, window_ + 1, iteration_);
    }
    if (!computed_) return {.kind = Action::Kind::compute, .window = window_, .iteration = iteration_};
    for (std::size_t e = 0; e < in_.size(); ++e)
        if (in_[e].inside && results_[e] <= iteration_) return await(e, window_ + 1, iteration_);
    return {.kind = Action::Kind::agree, .window = window_, .iteration = iteration_};
}

void Schedule::sent()
{
    assert(next().kind == Action::Kind::send);
    sent_ = true;
}

void Schedule::planned(Plan const& plan)
{
    assert(next().kind == Action::Kind::plan && plan.window == window_);
    plan_ = plan;
    planned_ = true;
}

void Schedule::stored()
{
    assert(next().kind == Action::Kind::checkpoint);
    stored_ = true;
}

void Schedule::computed()
{
    assert(next().kind == Action::Kind::compute);
    computed_ = true;
    if (!grouped_) go_on();
}

void Schedule::agreed(bool converged)
{
    assert(next().kind == Action::Kind::agree);
    if (converged) return go_on();
    ++iteration_;
    computed_ = false;
}

void Schedule::go_on()
{
    for (std::size_t e = 0; e < in_.size(); ++e)
        if (in_[e].inside) {
            ++arrived_[e];
            results_[e] = 0;
        }
    ++window_;
    iteration_ = 0;
    over_ = plan_.last;
    sent_ = planned_ = stored_ = computed_ = false;
}

bool Schedule::received(int edge, std::int64_t frame, std::uint32_t iteration)
{
    Action const action = next();
    if (action.kind != Action::Kind::await || action.edge != edge || action.frame != frame ||
        action.iteration != iteration)
        return false;
    auto const e = static_cast<std::size_t>(edge);
    if (in_[e].inside && frame == window_ + 1)
        ++results_[e];
    else
        ++arrived_[e];
    return true;
}

Weights sample_weights(InEdge const& edge, std::int64_t frames, double s, std::span<double const> past)
{
    assert(frames > 0 && static_cast<std::int64_t>(past.size()) >= frames - 1);
    if (edge.lag == 0 || edge.inside) {
        if (frames == 1) return {{1, 0, 0}};
        return {{s, 1 - s, 0}};
    }
    switch (std::min<std::int64_t>(edge.predict, frames - 1)) {
        case 0:
            return {{1, 0, 0}};
        case 1: {
            double const a = past[0];
            return {{(s + a) / a, -s / a, 0}};
        }
        default: {  // Lagrange through 0, -a, -b
            double const a = past[0], b = past[1];
            return {{(s + a) * (s + b) / (a * b), -s * (s + b) / (a * (b - a)), s * (s + a) / (b * (b - a))}};
        }
    }
}

}  // namespace sluice
