#include "coupler/session.hpp"

#include <fmt/format.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <random>

namespace sluice {
namespace {

//! Which participant this is. Throws Error (exit 2) if the scene has none of that name, or not so many processes.
int require_participant(Scene const& scene, JoinOptions const& options)
{
    int const index = scene.index_of(options.name);
    require(index >= 0 && is_identifier(options.name), [&] {
        return Error(scene.file.string() + ": no participant \"" + options.name +
                     "\" (participants: " + list_of(scene.participant_names()) + ").");
    });
    int const ranks = scene.participants[static_cast<std::size_t>(index)].ranks;
    require(options.rank >= 0 && options.rank < ranks, [&] {
        return Error(fmt::format("{}: participant \"{}\" has {} process{}, no rank {} (ranks count from 0).",
                                 scene.file.string(), options.name, ranks, ranks == 1 ? "" : "es", options.rank));
    });
    return index;
}

int require_member(std::vector<Member> const& members, int participant, int rank)
{
    for (std::size_t m = 0; m < members.size(); ++m)
        if (members[m].participant == participant && members[m].rank == rank) return static_cast<int>(m);
    throw Error("no such process.", Exit::internal);
}

//! The page of a process, in the directory of the run, which is made if need be; for a check nothing is written.
MappedStatus make_status(JoinOptions const& options, std::string const& name, std::unique_ptr<NameLock>& lock)
{
    if (options.check || options.given) return {name, MappedStatus::Mode::unshared};
    std::error_code error;
    std::filesystem::create_directories(options.directory / ".sluice", error);
    require(!error, [&] {
        return Error(
            options.directory.string() + ": " + error.message() + " (needed: a directory for results). Use --out.",
            Exit::io);
    });
    lock = std::make_unique<NameLock>(options.directory / ".sluice" / (name + ".lock"),
                                      "participant \"" + name + "\" already runs in " + options.directory.string());
    return {status_file(options.directory, name), MappedStatus::Mode::create};
}

ImplicitGroup const* group_of(Scene const& scene, int participant)
{
    for (auto const& group : scene.implicit)
        if (group.has(participant)) return &group;
    return nullptr;
}

LoadedScene load(JoinOptions const& options)
{
    return options.given ? *options.given : load_scene(options.scene, options.overrides);
}

std::vector<std::string> names_of(Scene const& scene, std::vector<Member> const& members)
{
    std::vector<std::string> names;
    for (auto const& member : members) names.push_back(name_of(scene, member));
    return names;
}

}  // namespace

std::vector<Member> members_of(Scene const& scene)
{
    std::vector<Member> members;
    for (std::size_t p = 0; p < scene.participants.size(); ++p)
        for (int rank = 0; rank < scene.participants[p].ranks; ++rank) members.push_back({static_cast<int>(p), rank});
    return members;
}

std::string name_of(Scene const& scene, Member const& member)
{
    auto const& spec = scene.participants[static_cast<std::size_t>(member.participant)];
    return spec.ranks == 1 ? spec.name : spec.name + ":" + std::to_string(member.rank);
}

std::string name_of(Scene const& scene, Edge const& edge)
{
    return scene.participants[static_cast<std::size_t>(edge.from)].name + " -> " +
           scene.participants[static_cast<std::size_t>(edge.to)].name + ": " +
           scene.data[static_cast<std::size_t>(edge.data)].name;
}

std::uint64_t new_nonce()
{
    std::random_device random;
    return random() | std::uint64_t{random()} << 32;
}

//! What is wrong until the solver has asked for the rotation.
Problem Participant::Session::unasked_rotation() const
{
    auto problem = scene.frame_place;
    problem.text = "frame = rotating: the solver of \"" + options.name +
                   "\" knows no frame but the inertial one (needs frame: inertial, or another solver).";
    return problem;
}

Participant::Session::Session(JoinOptions given)
    : options(std::move(given)),
      loaded(load(options)),
      scene(loaded.scene),
      members(members_of(scene)),
      names(names_of(scene, members)),
      participant(require_participant(scene, options)),
      self(require_member(members, participant, options.rank)),
      pacer(require_member(members, scene.pace, 0)),
      group(group_of(scene, participant)),
      status(make_status(options, name_of_member(self), lock)),
      greetings(members.size()),
      said_bye(members.size()),
      answered_(members.size()),
      may_reconnect_(!options.transport),
      waited_(scene.participants.size())
{
    if (scene.rotation) loaded.diagnostics->problems.push_back(unasked_rotation());
    verdicts_.resize(members.size());  // one may come before everybody has met
    status->pid = ::getpid();
    status->phase = Phase::preparing;
    mine().nonce = new_nonce();
    mine().process = ::getpid();
    auto const inside = [&](Edge const& e) { return group && group->has(e.from) && group->has(e.to); };
    for (std::size_t e = 0; e < scene.edges.size(); ++e) {
        Edge const& edge = scene.edges[e];
        auto const& spec = scene.data[static_cast<std::size_t>(edge.data)];
        if (edge.from != participant) continue;
        OutChannel channel{edge, static_cast<int>(e), spec, inside(edge), needs_credit(scene, edge)};
        for (std::size_t c = 0; c < spec.columns.size(); ++c) {
            if (spec.columns[c].name == "position" && spec.columns[c].shape == Shape::vector)
                channel.position = static_cast<int>(c);
            if (spec.columns[c].name == "radius" && spec.columns[c].shape == Shape::scalar)
                channel.radius = static_cast<int>(c);
        }
        out.push_back(std::move(channel));
    }
    for (std::size_t e = 0; e < scene.edges.size(); ++e) {
        Edge const& edge = scene.edges[e];
        if (edge.to != participant) continue;
        std::vector<int> senders;
        for (std::size_t m = 0; m < members.size(); ++m)
            if (members[m].participant == edge.from) senders.push_back(static_cast<int>(m));
        in.emplace_back(edge, static_cast<int>(e), inside(edge), scene.data[static_cast<std::size_t>(edge.data)],
                        scene.dimension, ~0u, senders);
    }
    if (scene.on_violation != OnViolation::off) open_accounts();
    if (!options.check && !options.given && !options.transport) begin_mpi_early(scene);
}

std::string Participant::Session::where() const
{
    return fmt::format("window {} of {} (t = {:.6g} s)", status->window.load(), status->windows.load(),
                       status->time.load());
}

Error Participant::Session::lost_peer(int member) const
{
    auto const trouble = transport->trouble(member);
    auto const what =
        trouble.empty() ? fmt::format("it ended, or was silent for {} s", scene.silence_timeout) : trouble;
    auto const process = greetings[static_cast<std::size_t>(member)].process;
    auto const peer = static_cast<std::size_t>(members[static_cast<std::size_t>(member)].participant);
    auto const& host = scene.participants[peer].host;
    bool const named = what.find("process") != what.npos || process <= 0;
    auto const who = named ? "" : fmt::format(" (process {}{})", process, host.empty() ? "" : " on " + host);
    return Error(fmt::format("participant \"{}\" is lost: {}{}, while \"{}\" was in {}. Look at its log.",
                             name_of_member(member), what, who, name_of_member(self), where()),
                 Exit::peer_died);
}

void Participant::Session::book(Activity activity)
{
    auto const now = Clock::now();
    auto& account = activity == Activity::compute ? status->compute_ns
                    : activity == Activity::wait  ? status->wait_ns
                                                  : status->exchange_ns;
    account.store(account.load(std::memory_order_relaxed) + (now - mark_).count(), std::memory_order_relaxed);
    auto const since_boot = [](Clock::time_point t) {
        return std::chrono::duration<double>(t.time_since_epoch()).count();
    };
    if (trace)
        trace->add(static_cast<std::uint64_t>(status->window.load(std::memory_order_relaxed)), activity,
                   since_boot(mark_), since_boot(now));
    mark_ = now;
}

bool Participant::Session::advance(Window& window)
{
    for (;;) {
        try {
            if (going_back_) go_back(*std::exchange(going_back_, std::nullopt));
            return advance_once(window);
        } catch (RollBack const& back) {
            going_back_ = back.why;
        }
    }
}

bool Participant::Session::advance_once(Window& window)
{
    if (computing) end_computing();
    for (;;) {
        Action const action = schedule->next();
        switch (action.kind) {
            case Action::Kind::send:
                emit_kept(action.frame);
                schedule->sent();
                break;
            case Action::Kind::plan:
                plan_window(action.window);
                break;
            case Action::Kind::await:
                await_frame(action);
                break;
            case Action::Kind::checkpoint:
                store(action.window);
                schedule->stored();
                break;
            case Action::Kind::agree:
                agree(action.window, action.iteration);
                break;
            case Action::Kind::compute:
                open_window(window, action);
                return true;
            case Action::Kind::finish:
                if (may_go_back()) say_goodbye();  // while there still is a solver that can go back
                stopped = schedule->stopped();
                book(Activity::exchange);
                return false;
        }
    }
}

//! The solver gives the word back: it has written what its edges need.
void Participant::Session::end_computing()
{
    book(Activity::compute);
    auto const frame = schedule->next().window + 1;
    require_written(frame);
    schedule->computed();
    computing = false;
    if (group) return;
    close_accounts();
    begin_ = plan_.begin + plan_.length;
    status->window = frame;
    status->time = pace.scale.seconds(begin_);
}

void Participant::Session::open_window(Window& window, Action const& action)
{
    plan_ = schedule->plan();
    if (group && action.iteration == 0) begin_group_window();
    double const begin = pace.scale.seconds(plan_.begin), end = pace.scale.seconds(plan_.begin + plan_.length);
    window = {.index = action.window,
              .begin = begin,
              .end = end,
              .length = plan_.length == ticks_per_window ? window_length : end - begin,
              .last = plan_.last,
              .iteration = static_cast<int>(action.iteration)};
    window.output = window.due(scene.output_interval);
    window.series = window.due(scene.series_interval);
    for (auto& channel : in) {
        channel.begin = plan_.begin;
        channel.length = plan_.length;
    }
    look_at(action.window);
    status->window.store(action.window, std::memory_order_relaxed);
    status->time.store(begin, std::memory_order_relaxed);
    book(Activity::exchange);
    computing = true;
}

bool Participant::Session::settle()
{
    if (going_back_) return false;
    try {
        return settle_now();
    } catch (RollBack const& back) {
        going_back_ = back.why;
        return false;
    }
}

bool Participant::Session::settle_now()
{
    if (!computing) return true;  // asked twice
    auto const window = plan_.window;
    end_computing();
    while (schedule->next().window == window) {
        Action const action = schedule->next();
        if (action.kind == Action::Kind::await)
            await_frame(action);
        else if (action.kind == Action::Kind::agree && !agree(action.window, action.iteration))
            return false;
    }
    return true;
}

void Participant::Session::leave()
{
    require(schedule && schedule->next().kind == Action::Kind::finish, [&] {
        return Error("participant \"" + name_of_member(self) +
                         "\" left its loop over the windows before their end, in " + where() + ".",
                     Exit::internal);
    });
    if (recording) recording->close();
    leaving_ = true;
    say_goodbye();
}

void Participant::Session::say_goodbye()
{
    if (!transport || said_goodbye_) return;
    finish_checkpoint();
    Header header{.kind = MessageKind::bye, .session = session, .frame = status->window};
    seal(header);
    auto const deadline = now() + in_milliseconds(scene.connect_timeout);
    said_bye[static_cast<std::size_t>(self)] = true;
    for (int m = 0; m < static_cast<int>(members.size()); ++m)
        if (m != self) send(m, bytes_of(header), deadline);
    for (std::size_t m = 0; m < said_bye.size(); ++m) {
        int lost = 0;
        while (!said_bye[m]) {
            answer_late_greetings();
            auto const incoming = transport->receive(std::chrono::milliseconds(100));
            if (incoming)
                handle(*incoming);
            else if (transport->lost(static_cast<int>(m)) && ++lost > 1) {
                if (is_done(static_cast<int>(m))) break;  // it said so elsewhere: its last words did not get through
                stop_because(lost_peer(static_cast<int>(m)));
            } else
                look_for_newcomers();
        }
    }
    said_goodbye_ = true;
    book(Activity::wait);
}

void Participant::Session::tell_peers(std::string const& why) noexcept
{
    if (!transport || consequence) return;
    try {
        auto const bytes =
            encode_text({.kind = MessageKind::abort, .session = session, .frame = status->window.load()}, why);
        for (int m = 0; m < static_cast<int>(members.size()); ++m)
            if (m != self) (void)transport->try_send(m, bytes);
    } catch (...) {  // the run is over in any case; what went wrong first is what gets reported
    }
}

}  // namespace sluice
