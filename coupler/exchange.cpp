// Frames and messages of a Session: what is sent, what is taken in, and how it waits.

#include <fmt/format.h>

#include <algorithm>

#include "coupler/session.hpp"
#include "coupler/transport/buffer.hpp"

namespace sluice {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds patience{100};  // of one look for messages; between two, lost peers are looked for

constexpr std::int64_t frames_ahead = 4;  // that a sender may be ahead of a receiver from which nothing comes back

}  // namespace

bool needs_credit(Scene const& scene, Edge const& edge)
{
    return std::none_of(scene.edges.begin(), scene.edges.end(),
                        [&](Edge const& other) { return other.from == edge.to && other.to == edge.from; });
}

void Participant::Session::wait_for(int member, std::function<bool()> const& done)
{
    std::vector<char> lost;  // no memory is asked for as long as something comes
    while (!done()) {
        answer_late_greetings();
        book(Activity::exchange);
        auto const incoming = transport->receive(patience);
        auto const before = mark_;
        book(Activity::wait);
        waited_[static_cast<std::size_t>(members[static_cast<std::size_t>(member)].participant)] +=
            (mark_ - before).count();
        if (incoming) {
            handle(*incoming);
            continue;
        }
        look_for_requests();
        look_for_newcomers();
        require(!said_bye[static_cast<std::size_t>(member)], [&] {
            return Error(fmt::format("participant \"{}\" left its run early; \"{}\" still needs it in {}.",
                                     name_of_member(member), name_of_member(self), where()),
                         Exit::peer_died);
        });
        look_for_lost(lost);
    }
}

//! While nothing comes: anybody who was lost at the last look, too, ends the run; what he sent has been read by now.
void Participant::Session::look_for_lost(std::vector<char>& before)
{
    before.resize(members.size());
    for (int m = 0; m < static_cast<int>(members.size()); ++m) {
        auto const at = static_cast<std::size_t>(m);
        bool const now = m != self && !said_bye[at] && transport->lost(m);
        if (now && before[at]) stop_because(lost_peer(m));
        before[at] = now;
    }
}

void Participant::Session::handle(Transport::Incoming const& incoming)
{
    auto const& peer_name = name_of_member(incoming.peer);
    auto const& message = incoming.message;
    Header const header = open_message(message.bytes, peer_name);
    if (header.kind == MessageKind::hello) return handle_greeting(incoming.peer, text_of(message.bytes));
    bool const ours = header.session == session;
    if (header.kind == MessageKind::abort) {
        if (!ours && header.session != 0 && scene.restart_on_death) return;  // from before it was started again
        stop_because(Error(
            fmt::format("participant \"{}\" stopped in window {}: {}", peer_name, header.frame, text_of(message.bytes)),
            Exit::peer_died));
    }
    if (session == 0) {  // a peer that met everybody first does not wait until we have
        early_.push_back(incoming);
        return;
    }
    if (!ours && scene.restart_on_death) return;  // from before we met again
    require(ours, [&] {
        return Error("message from \"" + peer_name + "\" of another run. End what is left of it.", Exit::protocol);
    });
    switch (header.kind) {
        case MessageKind::bye:
            said_bye[static_cast<std::size_t>(incoming.peer)] = true;
            return;
        case MessageKind::credit:
            for (auto& channel : out)
                if (channel.number == static_cast<int>(header.edge))
                    for (auto& target : channel.targets)
                        if (target.member == incoming.peer) target.used = std::max(target.used, header.frame);
            return;
        case MessageKind::plan:
            return take_plan(incoming.peer, header);
        case MessageKind::verdict:
            return take_verdict(incoming.peer, header, numbers_of(message.bytes));
        case MessageKind::request:
            return take_request(static_cast<std::int32_t>(header.columns));
        case MessageKind::power:
            return hear_power(incoming.peer, header, numbers_of(message.bytes));
        case MessageKind::stored:
            return take_report(incoming.peer, header.frame, text_of(message.bytes));
        case MessageKind::frame:
            for (auto& channel : in)
                if (channel.number == static_cast<int>(header.edge))
                    return channel.arrive(incoming.peer, header, message, peer_name);
            break;
        default:
            break;
    }
    throw Error("message from \"" + peer_name + "\" that the scene does not have.", Exit::protocol);
}

//! No room to send: the receiver is slower. Takes in what has come meanwhile.
void Participant::Session::stalled(int member, Clock::time_point deadline)
{
    book(Activity::exchange);
    if (auto const incoming = transport->receive(milliseconds(1))) handle(*incoming);
    book(Activity::wait);
    if (transport->lost(member)) stop_because(lost_peer(member));
    look_for_newcomers();
    require(now() < deadline, [&] {
        return Error("\"" + name_of_member(member) + "\" takes nothing in: no room to send within the time allowed.",
                     Exit::timeout);
    });
}

void Participant::Session::send(int member, std::span<std::byte const> bytes, Clock::time_point deadline)
{
    while (!transport->try_send(member, bytes)) stalled(member, deadline);
}

void Participant::Session::broadcast(std::span<std::byte const> bytes)
{
    for (int m = 0; m < static_cast<int>(members.size()); ++m)
        if (m != self) send(m, bytes, Clock::time_point::max());
}

std::span<std::byte> Participant::Session::room_for(int member, std::size_t size)
{
    for (;;) {
        auto const room = transport->reserve(member, size);
        if (room.size() >= size && room.data() != nullptr) return room;
        stalled(member, Clock::time_point::max());
    }
}

void Participant::Session::commit(int member, std::size_t size)
{
    while (!transport->commit(member, size)) stalled(member, Clock::time_point::max());
    bytes_sent += static_cast<std::int64_t>(size);
}

//! Waits while the receiver is more than `frames_ahead` behind.
void Participant::Session::await_credit(OutChannel& channel, OutChannel::Target& target, std::int64_t frame)
{
    if (!channel.credit || frame - target.used <= frames_ahead) return;
    auto const& bye = said_bye[static_cast<std::size_t>(target.member)];
    wait_for(target.member, [&] { return frame - target.used <= frames_ahead || bye; });
}

//! One target for each process of the receivers, as they described themselves at the handshake.
void Participant::Session::open_channels()
{
    for (auto& channel : out)
        for (std::size_t m = 0; m < members.size(); ++m) {
            if (members[m].participant != channel.edge.to) continue;
            auto const& greeting = greetings[m];
            auto const wanted = greeting.columns.find(channel.number);
            auto const mask = wanted == greeting.columns.end() ? ~0u : wanted->second;
            channel.targets.push_back(
                {static_cast<int>(m),
                 FrameEncoder(channel.spec, scene.dimension, static_cast<std::uint32_t>(channel.number), mask),
                 greeting.box});
        }
}

void Participant::Session::write(OutChannel& channel, std::span<std::int64_t const> ids,
                                 std::vector<std::span<double const>> const& columns)
{
    if (going_back_) return;  // this window will be computed again
    try {
        write_now(channel, ids, columns);
    } catch (RollBack const& back) {
        going_back_ = back.why;
    }
}

void Participant::Session::write_now(OutChannel& channel, std::span<std::int64_t const> ids,
                                     std::vector<std::span<double const>> const& columns)
{
    if (!schedule) {
        channel.keep(ids, columns);
        channel.written = 0;
        return;
    }
    auto const& action = schedule->next();
    require(computing && (channel.written <= plan_.window || (group && channel.iteration < action.iteration)), [&] {
        return Error("participant \"" + name_of_member(self) + "\" wrote " + channel.spec.name + " twice in " +
                         where() + ", or between two windows (once at the end of each).",
                     Exit::internal);
    });
    channel.written = plan_.window + 1;
    channel.iteration = action.iteration;
    book(Activity::compute);
    if (group && !channel.inside)
        channel.keep(ids, columns);
    else
        emit(channel, channel.written, action.iteration, ids, columns);
    book(Activity::exchange);
}

void Participant::Session::require_written(std::int64_t frame) const
{
    for (auto const& channel : out)
        require(channel.written == frame && (!group || frame == 0 || channel.iteration == schedule->next().iteration),
                [&] {
                    return Error("participant \"" + name_of_member(self) + "\" wrote nothing to \"" +
                                     scene.participants[static_cast<std::size_t>(channel.edge.to)].name + "\" before " +
                                     where() + " (a state is needed at the start and at the end of every window).",
                                 Exit::internal);
                });
}

//! What was kept goes out: the initial state, or what leaves an implicit group once its window stands.
void Participant::Session::emit_kept(std::int64_t frame)
{
    if (frame == 0) require_written(0);
    if (frame > 0 && !group) return;
    for (auto& channel : out) {
        if (frame > 0 && channel.inside) continue;
        std::vector<std::span<double const>> const columns(channel.columns.begin(), channel.columns.end());
        emit(channel, frame, 0, channel.ids, columns);
    }
}

void Participant::Session::emit(OutChannel& channel, std::int64_t frame, std::uint32_t iteration,
                                std::span<std::int64_t const> ids, std::vector<std::span<double const>> const& columns)
{
    auto const ticks = frame == 0 ? 0 : plan_.begin + plan_.length;
    Samples::Source const* back = nullptr;  // tells from which process of the receiver a point came
    bool const several = std::ranges::count_if(channel.targets, &OutChannel::Target::takes_points) > 1;
    if (channel.position < 0 && several && !channel.spec.meshless)
        for (auto const& source : in)
            if (source.edge.from == channel.edge.to && !source.spec.meshless && !source.history.empty()) back = &source;
    // else what is written is sent, untouched
    bool const filtered =
        channel.position >= 0 && (channel.edge.region || (!channel.targets.empty() && channel.targets[0].box));
    bool const counted = channel.account && (channel.targets.size() > 1 || filtered);
    std::vector<int> went(counted ? ids.size() : 0);  // to how many processes each point went
    if (recording) record(channel, {frame, ticks, 0, ids, columns});
    keep_for_work(channel, {frame, ticks, iteration, ids, columns});
    for (std::size_t t = 0; t < channel.targets.size(); ++t) {
        auto& target = channel.targets[t];
        await_credit(channel, target, frame);
        Selection chosen;
        Outgoing outgoing{frame, ticks, iteration, ids, columns};
        std::vector<std::span<double const>> spans;
        bool const by_place = channel.position >= 0 && (channel.edge.region || target.box);
        bool const nothing = !channel.spec.meshless && !target.takes_points();
        if (by_place || back || nothing) {
            auto const d = static_cast<std::size_t>(scene.dimension);
            auto const wanted = [&](std::size_t i) {
                if (nothing) return false;
                if (back) return std::max(back->origin_of(ids[i]), 0) == static_cast<int>(t);
                double const* const at = columns[static_cast<std::size_t>(channel.position)].data() + i * d;
                double const r = channel.radius < 0 ? 0 : columns[static_cast<std::size_t>(channel.radius)][i];
                return (!channel.edge.region || reaches(*channel.edge.region, at, scene.dimension, r)) &&
                       (!target.box || reaches(*target.box, at, scene.dimension, r));
            };
            std::vector<std::size_t> widths;
            for (auto const& column : channel.spec.columns)
                widths.push_back(static_cast<std::size_t>(components(column.shape, scene.dimension)));
            chosen.take(ids, columns, widths, [&](std::size_t i) {
                bool const goes = wanted(i);
                if (counted && goes) ++went[i];
                return goes;
            });
            spans.assign(chosen.columns.begin(), chosen.columns.end());
            outgoing.ids = chosen.ids;
            outgoing.columns = spans;
        } else if (counted)
            for (int& count : went) ++count;
        if (channel.work && is_looked_at(frame - 1, scene.energy_every)) say_power(channel, target.member, outgoing);
        auto const room = room_for(target.member, target.encoder.bound(outgoing.ids.size()));
        commit(target.member, target.encoder.encode(outgoing, session, name_of_member(self), room));
    }
    if (counted) book_sent(channel, columns, went);
}

//! A frame as the solver wrote it, whole.
void Participant::Session::record(OutChannel const& channel, Outgoing const& frame)
{
    FrameEncoder encoder(channel.spec, scene.dimension, static_cast<std::uint32_t>(channel.number));
    Buffer buffer;
    auto const room = buffer.room(encoder.bound(frame.ids.size()));
    auto const size = encoder.encode(frame, session, name_of_member(self), room);
    recording->append(static_cast<std::uint32_t>(channel.number), frame.index, room.first(size));
}

//! What was written, and where it went: amounts that add up must go to exactly one process, or lie outside of all.
void Participant::Session::book_sent(OutChannel& channel, std::vector<std::span<double const>> const& columns,
                                     std::vector<int> const& went)
{
    Totals const written = totals_of(channel.spec, scene.dimension, columns);
    Totals sent, outside;
    for (std::size_t c = 0; c < columns.size(); ++c) {
        if (!is_amount(channel.spec.columns[c])) continue;
        auto const width = static_cast<std::size_t>(components(channel.spec.columns[c].shape, scene.dimension));
        auto const at = sent.size();
        sent.resize(at + width);
        outside.resize(at + width);
        for (std::size_t i = 0; i < went.size(); ++i)
            for (std::size_t k = 0; k < width; ++k) {
                double const value = columns[c][i * width + k];
                if (went[i] == 0) outside[at + k] += value;
                sent[at + k] += channel.spec.additive ? went[i] * value : (went[i] > 0 ? value : 0.0);
            }
    }
    channel.account->sent(written, sent, outside);
    check_account(*channel.account);
}

void Participant::Session::await_frame(Action const& action)
{
    auto& channel = in[static_cast<std::size_t>(action.edge)];
    for (auto const& origin : channel.origins)
        if (origin.pending.empty()) wait_for(origin.member, [&] { return !origin.pending.empty(); });
    bool const right = channel.has(action.frame, action.iteration);
    require(right && schedule->received(action.edge, action.frame, action.iteration), [&] {
        return Error(fmt::format("frame {} from \"{}\" is missing in {}.", action.frame,
                                 scene.participants[static_cast<std::size_t>(channel.edge.from)].name, where()),
                     Exit::protocol);
    });
    auto const& plan = schedule->plan();
    auto const due = action.frame == action.window ? plan.begin : plan.begin + plan.length;
    for (auto const& origin : channel.origins)
        require(origin.pending.front().ticks == due, [&] {
            return Error(fmt::format("frame {} from \"{}\" stands at tick {} (needed: {}) in {}.", action.frame,
                                     name_of_member(origin.member), origin.pending.front().ticks, due, where()),
                         Exit::protocol);
        });
    take_power(channel, action);
    take_frame(channel, action);
    if (!needs_credit(scene, channel.edge)) return;
    Header credit{.kind = MessageKind::credit,
                  .session = session,
                  .edge = static_cast<std::uint32_t>(channel.number),
                  .frame = action.frame};
    seal(credit);
    for (auto const& origin : channel.origins) send(origin.member, bytes_of(credit), Clock::time_point::max());
}

}  // namespace sluice
