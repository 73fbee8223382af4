#include "coupler/schedule/schedule.hpp"

#include <algorithm>
#include <cassert>
#include <utility>

namespace sluice {

Schedule::Schedule(std::vector<InEdge> in, std::int64_t windows)
    : in_(std::move(in)), arrived_(in_.size(), 0), windows_(windows)
{
    assert(windows >= 0);
}

std::int64_t Schedule::needed(int edge, std::int64_t window) const
{
    return window + 1 - in_[static_cast<std::size_t>(edge)].lag;
}

Action Schedule::next() const
{
    if (must_send_) return {.kind = Action::Kind::send, .window = window_, .frame = window_};
    if (window_ == windows_) return {.kind = Action::Kind::finish, .window = window_};
    for (std::size_t e = 0; e < in_.size(); ++e) {
        int const edge = static_cast<int>(e);
        if (arrived_[e] <= needed(edge, window_))
            return {.kind = Action::Kind::await, .window = window_, .frame = arrived_[e], .edge = edge};
    }
    return {.kind = Action::Kind::compute, .window = window_};
}

void Schedule::sent()
{
    assert(must_send_);
    must_send_ = false;
}

void Schedule::computed()
{
    assert(next().kind == Action::Kind::compute);
    ++window_;
    must_send_ = true;
}

bool Schedule::received(int edge, std::int64_t frame)
{
    auto& arrived = arrived_[static_cast<std::size_t>(edge)];
    if (frame != arrived || frame > windows_) return false;
    ++arrived;
    return true;
}

Weights sample_weights(InEdge const& edge, std::int64_t frames, double s)
{
    assert(frames > 0);
    if (edge.lag == 0) {
        if (frames == 1) return {{1, 0, 0}};
        return {{s, 1 - s, 0}};
    }
    switch (std::min<std::int64_t>(edge.predict, frames - 1)) {
        case 0:
            return {{1, 0, 0}};
        case 1:
            return {{1 + s, -s, 0}};
        default:
            return {{(1 + s) * (2 + s) / 2, -s * (2 + s), s * (1 + s) / 2}};  // Lagrange through 0, -1, -2
    }
}

}  // namespace sluice
