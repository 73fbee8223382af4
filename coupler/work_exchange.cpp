// The books of energy in a Session: what a sender of loads reckons, what it says of it, and what the receiver compares.
#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "coupler/session.hpp"

namespace sluice {
namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

template <class Channels>
auto& with_number(Channels& channels, int number)
{
    return *std::find_if(channels.begin(), channels.end(), [&](auto const& c) { return c.number == number; });
}

//! Of the edge of loads with this number, if a motion comes back.
std::optional<Work> work_of(Scene const& scene, int number)
{
    int const back = motion_edge(scene, number);
    if (back < 0) return std::nullopt;
    Edge const& edge = scene.edges[static_cast<std::size_t>(number)];
    Edge const& motion = scene.edges[static_cast<std::size_t>(back)];
    auto const& data = scene.data;
    return Work{.pairs = power_pairs(data[static_cast<std::size_t>(edge.data)],
                                     data[static_cast<std::size_t>(motion.data)], scene.dimension),
                .motion = back,
                .lag = motion.lag,
                .whole_window = edge.sample == Sampling::hold};
}

}  // namespace

void Participant::Session::open_work()
{
    if (scene.energy_every == 0) return;
    for (auto& channel : in) {
        channel.looking = false;
        channel.tally.columns.assign(channel.spec.columns.size(), 0);
        channel.work = work_of(scene, channel.number);
        if (channel.work) channel.work->account.emplace(name_of(scene, channel.edge));
    }
    for (auto& channel : out) {
        channel.kept.clear();
        channel.work_columns.clear();
        channel.work = work_of(scene, channel.number);
    }
    auto const want = [](std::vector<char>& columns, std::size_t size, std::size_t column) {
        columns.resize(size);
        columns[column] = 1;
    };
    for (auto& channel : in) {
        if (!channel.work) continue;
        auto& motion = with_number(out, channel.work->motion);
        for (auto const& pair : channel.work->pairs) {
            channel.tally.columns[pair.load] = 1;
            want(motion.work_columns, motion.spec.columns.size(), pair.motion);
        }
    }
    for (auto& channel : out) {
        if (!channel.work) continue;
        auto& motion = with_number(in, channel.work->motion);
        for (auto const& pair : channel.work->pairs) {
            motion.tally.columns[pair.motion] = 1;
            if (!channel.work->whole_window) want(channel.work_columns, channel.spec.columns.size(), pair.load);
        }
    }
}

//! A window begins: whether its samples are added up.
void Participant::Session::look_at(std::int64_t window)
{
    bool const looked = is_looked_at(window, scene.energy_every);
    for (auto& channel : in) {
        auto const& wanted = channel.tally.columns;
        channel.looking = looked && std::find(wanted.begin(), wanted.end(), 1) != wanted.end();
        if (channel.looking) channel.tally.restart();
    }
}

//! A frame that stands at one end of a window that is looked at.
void Participant::Session::keep_for_work(OutChannel& channel, Outgoing const& frame)
{
    if (channel.work_columns.empty()) return;
    if (is_looked_at(frame.index, scene.energy_every) || is_looked_at(frame.index - 1, scene.energy_every))
        remember(channel.kept, frame.index, frame.ids, frame.columns, channel.work_columns);
}

//! Before the frame: what it gives, by the motion that came here.
void Participant::Session::say_power(OutChannel& channel, int member, Outgoing const& frame)
{
    Work const& work = *channel.work;
    auto& motion = with_number(in, work.motion);
    SaidPower said{.of_frame = std::vector<double>(work.pairs.size(), unknown),
                   .of_window = std::vector<double>(work.pairs.size(), unknown)};
    KeptPoints const* const before = work.whole_window ? nullptr : kept_frame(channel.kept, frame.index - 1);
    std::vector<FramePart> loads{{{frame.ids, {frame.columns.begin(), frame.columns.end()}}, 1.0}};
    bool const looked = motion.looking && motion.tally.samples > 0 && (work.whole_window || before);
    for (std::size_t p = 0; p < work.pairs.size() && looked; ++p) {
        auto const& [load, column, width, label] = work.pairs[p];
        if (unread(motion, column)) continue;
        FramePart const newest{view_of(motion.newest()), 1.0}, mean = motion.tally.mean();
        loads.resize(1);
        loads[0].weight = 1;
        said.of_frame[p] = power_of(load, column, width, loads, {&newest, 1}).net;
        if (before) {
            loads[0].weight = 0.5;
            loads.push_back({before->view(), 0.5});
        }
        said.of_window[p] = power_of(load, column, width, loads, {&mean, 1}).net;
    }
    auto const numbers = said.numbers();
    send(member,
         encode({.kind = MessageKind::power,
                 .session = session,
                 .edge = static_cast<std::uint32_t>(channel.number),
                 .frame = frame.index,
                 .iteration = frame.iteration},
                std::as_bytes(std::span(numbers))),
         Clock::time_point::max());
}

void Participant::Session::hear_power(int member, Header const& header, std::span<double const> numbers)
{
    auto const channel = std::find_if(
        in.begin(), in.end(), [&](Samples::Source const& c) { return c.number == static_cast<int>(header.edge); });
    if (channel != in.end() && channel->work)
        for (auto& origin : channel->origins)
            if (auto said = SaidPower::from(numbers, channel->work->pairs.size()); said && origin.member == member) {
                said->frame = header.frame;
                said->iteration = header.iteration;
                origin.said.push_back(std::move(*said));
                return;
            }
    throw Error("a power of \"" + name_of_member(member) + "\" in " + where() + " that the scene does not have.",
                Exit::protocol);
}

//! Whether the solver said that it does not read this column.
bool Participant::Session::unread(Samples::Source const& channel, std::size_t column) const
{
    auto const mask = reads.find(channel.number);
    return mask != reads.end() && !(mask->second & (1u << column));
}

//! The frames of all processes of the sender are there, each by itself: what they give, by our motion and by theirs.
void Participant::Session::take_power(Samples::Source& channel, Action const& action)
{
    auto const window = action.frame - 1;
    if (!channel.work || !is_looked_at(window, scene.energy_every)) return;
    Work& work = *channel.work;
    auto const* const motion =
        kept_frame(with_number(out, work.motion).kept, work.lag == 0 ? action.frame : action.frame - 1);
    std::vector<double> given(work.pairs.size());
    for (auto& origin : channel.origins) {
        require(!origin.said.empty() && origin.said.front().frame == action.frame &&
                    origin.said.front().iteration == action.iteration,
                [&] {
                    return Error(fmt::format("what frame {} of {} from \"{}\" gives is missing in {}.", action.frame,
                                             channel.spec.name, name_of_member(origin.member), where()),
                                 Exit::protocol);
                });
        SaidPower const said = std::move(origin.said.front());
        origin.said.pop_front();
        for (std::size_t p = 0; p < work.pairs.size(); ++p) {
            auto const& [load, column, width, label] = work.pairs[p];
            given[p] += said.of_window[p];
            // inside a group the sender may have used a motion that was relaxed after we wrote it
            if (!motion || channel.terms.inside || std::isnan(said.of_frame[p]) || unread(channel, load)) continue;
            FramePart const loads{view_of(origin.pending.front()), 1.0}, ours{motion->view(), 1.0};
            auto const found = power_of(load, column, width, {&loads, 1}, {&ours, 1});
            work.account->same(window, "sent", said.of_frame[p], "received", found.net, found.moved);
        }
    }
    work.account->given(window, given);
}

//! A window stands: what the solver was handed, times the mean of its old and new motion.
void Participant::Session::close_work(Samples::Source& channel, double length)
{
    if (!channel.work || !channel.looking) return;
    Work& work = *channel.work;
    auto const window = plan_.window;
    auto const& kept = with_number(out, work.motion).kept;
    KeptPoints const* const old = kept_frame(kept, window);
    KeptPoints const* const now = kept_frame(kept, window + 1);
    if (!old || !now) return;  // right after a run was resumed
    FramePart const motions[] = {{now->view(), 0.5}, {old->view(), 0.5}};
    auto& tally = channel.tally;
    std::vector<FramePart> as_came;
    // a frame that was handed out as it came has nothing to be compared with
    bool const mixed = tally.samples > 0 && tally.whole.empty() && !channel.terms.inside;
    for (std::size_t k = 0; k < 3 && mixed; ++k) {
        double const weight = tally.weights[k] / tally.samples;
        if (k > 0 && weight == 0.0) continue;
        as_came.push_back({view_of(channel.history[k]), weight});
    }
    std::vector<Power> taken(work.pairs.size());
    for (std::size_t p = 0; p < work.pairs.size(); ++p) {
        auto const& [load, column, width, label] = work.pairs[p];
        if (unread(channel, load)) {
            taken[p].net = unknown;
            continue;
        }
        if (tally.samples == 0) continue;  // nothing was taken
        FramePart const mean = tally.mean();
        taken[p] = power_of(load, column, width, {&mean, 1}, motions);
        if (as_came.empty()) continue;
        auto const came = power_of(load, column, width, as_came, motions);
        work.account->same(window, "came", came.net, "taken", taken[p].net, came.moved);
    }
    work.account->taken(window, std::move(taken), length);
    flag(work.account->violation(scene.ledger_tolerance), energy_warned_);
    flag(work.account->excess(scene.energy_tolerance), staggering_warned_);
}

}  // namespace sluice
