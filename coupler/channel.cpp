#include "coupler/channel.hpp"

#include <algorithm>
#include <cassert>
#include <unordered_map>

namespace sluice {
namespace {

//! `old` with the points of `ids` in their order; a point that `old` lacks takes the values of `newest`.
Frame rearranged(Frame const& old, Frame const& newest)
{
    std::unordered_map<std::int64_t, std::size_t> at;
    for (std::size_t i = 0; i < old.ids.size(); ++i) at.emplace(old.ids[i], i);
    Frame result = newest;
    result.index = old.index;
    result.time = old.time;
    for (std::size_t i = 0; i < newest.ids.size(); ++i) {
        auto const found = at.find(newest.ids[i]);
        if (found == at.end()) continue;
        for (std::size_t c = 0; c < newest.columns.size(); ++c) {
            auto const width = newest.columns[c].size() / newest.ids.size();
            std::copy_n(old.columns[c].begin() + static_cast<std::ptrdiff_t>(found->second * width), width,
                        result.columns[c].begin() + static_cast<std::ptrdiff_t>(i * width));
        }
    }
    return result;
}

}  // namespace

bool needs_credit(Scene const& scene, Edge const& edge)
{
    return std::none_of(scene.edges.begin(), scene.edges.end(),
                        [&](Edge const& other) { return other.from == edge.to && other.to == edge.from; });
}

void Samples::Source::take_next()
{
    assert(!pending.empty());
    history.push_front(std::move(pending.front()));
    pending.pop_front();
    auto const kept = static_cast<std::size_t>(Schedule::kept(terms));
    if (history.size() > kept) history.resize(kept);
    for (std::size_t k = 1; k < history.size(); ++k)
        if (history[k].ids != history[0].ids) history[k] = rearranged(history[k], history[0]);
}

std::vector<std::span<double const>> const& Samples::Source::columns(double s)
{
    assert(!history.empty());
    auto const weights =
        sample_weights(terms, static_cast<std::int64_t>(history.size()), edge.sample == Sampling::hold ? 1.0 : s);
    auto const& newest = history.front();
    spans_.assign(newest.columns.begin(), newest.columns.end());
    if (weights.at[0] == 1.0 && weights.at[1] == 0.0 && weights.at[2] == 0.0) return spans_;
    mixed_.resize(newest.columns.size());
    for (std::size_t c = 0; c < mixed_.size(); ++c) {
        mixed_[c].assign(newest.columns[c].size(), 0.0);
        for (std::size_t k = 0; k < history.size(); ++k)
            for (std::size_t i = 0; i < mixed_[c].size(); ++i) mixed_[c][i] += weights.at[k] * history[k].columns[c][i];
        spans_[c] = mixed_[c];
    }
    return spans_;
}

std::span<std::int64_t const> Samples::ids() const
{
    return source_->history.front().ids;
}

std::vector<std::span<double const>> const& Samples::columns(double time)
{
    return source_->columns((time - begin_) / (end_ - begin_));
}

}  // namespace sluice
