#include "coupler/channel.hpp"

#include <algorithm>
#include <cassert>
#include <unordered_map>

#include "coupler/places.hpp"

namespace sluice {
namespace {

std::vector<std::size_t> widths_of(DataSpec const& spec, int dimension)
{
    std::vector<std::size_t> widths;
    for (auto const& column : spec.columns)
        widths.push_back(static_cast<std::size_t>(components(column.shape, dimension)));
    return widths;
}

//! `old` with the points of `newest` in their order; a point that `old` lacks takes the values of `newest`.
Frame rearranged(Frame const& old, Frame const& newest, std::vector<std::size_t> const& widths)
{
    auto const places = places_of(newest.ids.values, old.ids.values);
    Frame result = newest;
    result.index = old.index;
    result.ticks = old.ticks;
    result.totals.clear();
    for (std::size_t c = 0; c < newest.columns.size(); ++c) {
        auto const& now = newest.columns[c].values;
        if (now.empty()) continue;
        std::vector<double> values(now.begin(), now.end());
        double const* const before = old.columns[c].values.data();
        for (std::size_t i = 0; i < places.size(); ++i)
            if (places[i] != nowhere)
                std::copy_n(before + places[i] * widths[c], widths[c], values.data() + i * widths[c]);
        result.columns[c] = Held<double>::of(std::move(values));
    }
    return result;
}

}  // namespace

Samples::Source::Source(Edge const& edge, int number, bool inside, DataSpec const& spec, int dimension,
                        std::uint32_t wanted, std::vector<int> const& senders)
    : edge(edge), terms{edge.lag, edge.predict, inside}, number(number), spec(spec), dimension(dimension)
{
    for (int member : senders) origins.push_back({member, FrameDecoder(spec, dimension, wanted)});
}

void Samples::Source::arrive(int member, Header const& header, Message const& message, std::string const& sender)
{
    auto const origin =
        std::find_if(origins.begin(), origins.end(), [&](Origin const& o) { return o.member == member; });
    require(origin != origins.end(), [&] {
        return Error("frame from \"" + sender + "\" on an edge that the scene does not have.", Exit::protocol);
    });
    bool const next_frame = header.frame == origin->frame + 1 && header.iteration == 0;
    bool const next_iteration =
        terms.inside && header.frame > 0 && header.frame == origin->frame && header.iteration == origin->iteration + 1;
    require(next_frame || next_iteration, [&] {
        return Error("frame " + std::to_string(header.frame) + " of " + spec.name + " from \"" + sender +
                         "\" came out of turn, after frame " + std::to_string(origin->frame) +
                         ": one was lost or doubled.",
                     Exit::protocol);
    });
    origin->pending.push_back(origin->decoder.decode(header, message.bytes, message.owner, sender));
    origin->frame = header.frame;
    origin->iteration = header.iteration;
}

bool Samples::Source::has(std::int64_t frame, std::uint32_t iteration) const
{
    return std::all_of(origins.begin(), origins.end(), [&](Origin const& o) {
        return !o.pending.empty() && o.pending.front().index == frame && o.pending.front().iteration == iteration;
    });
}

Frame Samples::Source::take()
{
    if (origins.size() == 1) {
        Frame frame = std::move(origins[0].pending.front());
        origins[0].pending.pop_front();
        return frame;
    }
    std::vector<Frame> parts;
    for (Origin& o : origins) {
        parts.push_back(std::move(o.pending.front()));
        o.pending.pop_front();
    }
    return merged(std::move(parts));
}

//! The points of all parts in their order. A point that several have counts once, or is the sum if the data adds up.
Frame Samples::Source::merged(std::vector<Frame> parts)
{
    auto const widths = widths_of(spec, dimension);
    std::unordered_map<std::int64_t, std::size_t> at;
    std::vector<std::int64_t> ids;
    std::vector<std::vector<double>> values(widths.size());
    origin_of_.clear();
    for (std::size_t p = 0; p < parts.size(); ++p)
        for (std::size_t i = 0; i < parts[p].points(); ++i) {
            auto const id = parts[p].ids.values[i];
            auto const [place, is_new] = at.emplace(id, ids.size());
            if (is_new) {
                ids.push_back(id);
                origin_of_.emplace(id, static_cast<int>(p));
            } else if (!spec.additive)
                continue;
            for (std::size_t c = 0; c < widths.size(); ++c) {
                if (parts[p].columns[c].values.empty()) continue;
                auto const from = parts[p].columns[c].values.subspan(i * widths[c], widths[c]);
                if (is_new)
                    values[c].insert(values[c].end(), from.begin(), from.end());
                else
                    for (std::size_t k = 0; k < widths[c]; ++k) values[c][place->second * widths[c] + k] += from[k];
            }
        }
    Frame frame = parts[0];
    frame.ids = Held<std::int64_t>::of(std::move(ids));
    for (std::size_t c = 0; c < values.size(); ++c) frame.columns[c] = Held<double>::of(std::move(values[c]));
    return frame;
}

int Samples::Source::origin_of(std::int64_t id) const
{
    if (origins.size() == 1) return 0;
    auto const found = origin_of_.find(id);
    return found == origin_of_.end() ? -1 : found->second;
}

void Samples::Source::set_origins(std::span<std::int64_t const> values)
{
    origin_of_.clear();
    for (std::size_t i = 0; i < values.size() && i < history.front().points(); ++i)
        origin_of_.emplace(history.front().ids.values[i], static_cast<int>(values[i]));
}

void Samples::Source::keep(Frame frame)
{
    history.push_front(std::move(frame));
    auto const kept = terms.inside ? std::max<std::int64_t>(2, Schedule::kept(terms)) : Schedule::kept(terms);
    while (static_cast<std::int64_t>(history.size()) > kept) history.pop_back();
}

void Samples::Source::forget()
{
    history.clear();
    guess.reset();
    result.reset();
    fitted_to_.fill(-1);
}

std::vector<std::span<double const>> const& Samples::Source::columns(double s)
{
    std::array<Frame*, 3> frames{guess ? &*guess : &history.front()};
    std::size_t count = 1;
    for (std::size_t k = guess ? 0 : 1; k < history.size() && count < frames.size(); ++k) frames[count++] = &history[k];
    return mix(terms, std::span(frames).first(count), edge.sample == Sampling::hold ? 1.0 : s, true);
}

std::vector<std::span<double const>> const& Samples::Source::predicted()
{
    std::array<Frame*, 3> frames{};
    std::size_t count = 0;
    for (auto& frame : history)
        if (count < frames.size()) frames[count++] = &frame;
    return mix({.lag = 1, .predict = terms.predict}, std::span(frames).first(count), 1.0, false);
}

void Samples::Source::fit_guess_to_result()
{
    if (!same_ids(guess->ids.values, result->ids.values))
        guess = rearranged(*guess, *result, widths_of(spec, dimension));
    if (!same_ids(history.front().ids.values, result->ids.values))
        history.front() = rearranged(history.front(), *result, widths_of(spec, dimension));
}

//! The sum of frames, newest first, that stands for the fraction `s` of the window.
std::vector<std::span<double const>> const& Samples::Source::mix(InEdge const& by, std::span<Frame* const> frames,
                                                                 double s, bool booked)
{
    std::array<double, 2> past{};
    for (std::size_t k = 1; k < frames.size(); ++k)
        past[k - 1] = static_cast<double>(begin - frames[k]->ticks) / static_cast<double>(length);
    auto const weights = sample_weights(by, static_cast<std::int64_t>(frames.size()), s, past);
    std::array<Frame*, 3> fitting{};
    std::copy(frames.begin(), frames.end(), fitting.begin());
    for (std::size_t k = 1; k < frames.size(); ++k)  // only now: most samples need no older frame
        if (weights.at[k] != 0.0) fitting[k] = fitted(k, *frames[k], *frames[0]);
    frames = std::span(fitting).first(frames.size());
    if (booked && account) book(frames, weights);
    combine(frames, weights);
    if (booked && looking) tally.add(*frames[0], spans_, {weights.at[0], weights.at[1], weights.at[2]});
    return spans_;
}

//! `old`, the k-th of the history, with the points of `newest`; the history itself stays as it came.
Frame* Samples::Source::fitted(std::size_t k, Frame& old, Frame const& newest)
{
    if (same_ids(old.ids.values, newest.ids.values)) return &old;
    auto& fit = fitted_[k];
    if (fit.index != old.index || fit.iteration != newest.iteration || fitted_to_[k] != newest.index ||
        !same_ids(fit.ids.values, newest.ids.values)) {
        fit = rearranged(old, newest, widths_of(spec, dimension));
        fit.iteration = newest.iteration;
        fitted_to_[k] = newest.index;
    }
    return &fit;
}

void Samples::Source::combine(std::span<Frame* const> frames, Weights const& weights)
{
    Frame const& top = *frames[0];
    spans_.resize(top.columns.size());
    for (std::size_t c = 0; c < spans_.size(); ++c) spans_[c] = top.columns[c].values;
    if (weights.at[0] == 1.0 && weights.at[1] == 0.0 && weights.at[2] == 0.0) return;
    mixed_.resize(spans_.size());
    for (std::size_t c = 0; c < mixed_.size(); ++c) {
        auto const n = spans_[c].size();
        mixed_[c].resize(n);
        double* const to = mixed_[c].data();
        double const* const newest = spans_[c].data();
        bool begun = false;  // the first two in one pass: most samples are of two
        for (std::size_t k = 1; k < frames.size(); ++k) {
            double const w = weights.at[k];
            if (w == 0.0) continue;
            double const* const from = frames[k]->columns[c].values.data();
            if (begun)
                for (std::size_t i = 0; i < n; ++i) to[i] += w * from[i];
            else
                for (std::size_t i = 0; i < n; ++i) to[i] = weights.at[0] * newest[i] + w * from[i];
            begun = true;
        }
        if (!begun)
            for (std::size_t i = 0; i < n; ++i) to[i] = weights.at[0] * newest[i];
        spans_[c] = mixed_[c];
    }
}

Totals const& Samples::Source::totals(Frame& frame) const
{
    if (!frame.totals.empty()) return frame.totals;
    std::vector<std::span<double const>> columns;
    for (auto const& column : frame.columns) columns.push_back(column.values);
    return frame.totals = totals_of(spec, dimension, columns);
}

//! A sample is a sum of frames, and so are its totals: they cost nothing a point.
void Samples::Source::book(std::span<Frame* const> frames, Weights const& weights)
{
    Totals sample;
    for (std::size_t k = 0; k < frames.size(); ++k) {
        if (weights.at[k] == 0.0) continue;
        auto const& part = totals(*frames[k]);
        sample.resize(part.size());
        for (std::size_t i = 0; i < part.size(); ++i) sample[i] += weights.at[k] * part[i];
    }
    account->taken(sample);
}

std::span<std::int64_t const> Samples::ids() const
{
    return source_->newest().ids.values;
}

std::vector<std::span<double const>> const& Samples::columns(double time)
{
    return source_->columns((time - begin_) / (end_ - begin_));
}

bool Samples::vary() const
{
    auto const& terms = source_->terms;
    return source_->edge.sample != Sampling::hold && (terms.lag == 0 || terms.inside || terms.predict > 0);
}

void OutChannel::keep(std::span<std::int64_t const> new_ids, std::vector<std::span<double const>> const& values)
{
    ids.assign(new_ids.begin(), new_ids.end());
    columns.resize(values.size());
    for (std::size_t c = 0; c < values.size(); ++c) columns[c].assign(values[c].begin(), values[c].end());
}

bool reaches(Box const& box, double const* position, int dimension, double radius)
{
    if (box.is_empty()) return false;
    for (int axis = 0; axis < dimension; ++axis) {
        auto const a = static_cast<std::size_t>(axis);
        if (position[axis] + radius < box.min[a] || position[axis] - radius > box.max[a]) return false;
    }
    return true;
}

}  // namespace sluice
