#include "coupler/session.hpp"

#include <fmt/format.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <random>
#include <sstream>

#include "coupler/record/atomic_file.hpp"

namespace sluice {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr milliseconds patience{100};  // of one look for messages; between two, lost peers are looked for

constexpr std::int64_t frames_ahead = 4;  // that a sender may be ahead of a receiver from which nothing comes back

//! Which participant this is. Throws Error (exit 2) if the scene has none of that name.
int require_member(Scene const& scene, std::string const& name)
{
    int const self = scene.index_of(name);
    std::string names;
    for (auto const& p : scene.participants) names += (names.empty() ? "" : ", ") + p.name;
    require(self >= 0 && is_identifier(name), [&] {
        return Error(scene.file.string() + ": no participant \"" + name + "\" (participants: " + names + ").");
    });
    return self;
}

//! The page of a participant, in the directory of the run, which is made if need be; for a check nothing is written.
MappedStatus make_status(JoinOptions const& options, std::unique_ptr<NameLock>& lock)
{
    if (options.check) return {options.name, MappedStatus::Mode::unshared};
    std::error_code error;
    std::filesystem::create_directories(options.directory / ".sluice", error);
    require(!error, [&] {
        return Error(
            options.directory.string() + ": " + error.message() + " (needed: a directory for results). Use --out.",
            Exit::io);
    });
    lock = std::make_unique<NameLock>(
        options.directory / ".sluice" / (options.name + ".lock"),
        "participant \"" + options.name + "\" already runs in " + options.directory.string());
    return {status_file(options.directory, options.name), MappedStatus::Mode::create};
}

//! A directory of ours alone for the ipc sockets of the run in `results`: short, since socket paths end at 107 bytes.
std::string socket_directory(std::filesystem::path const& results)
{
    char const* runtime = std::getenv("XDG_RUNTIME_DIR");
    bool const usable = runtime && std::string_view(runtime).size() < 50 && ::access(runtime, W_OK | X_OK) == 0;
    std::string const base = usable ? runtime : "/tmp";
    auto const key = std::filesystem::absolute(results).lexically_normal().string();
    auto const parent = fmt::format("{}/sluice-{}", base, ::getuid());
    auto const path = fmt::format("{}/{:016x}", parent, XXH3_64bits(key.data(), key.size()));
    for (auto const& p : {parent, path}) {
        ::mkdir(p.c_str(), 0700);
        struct stat info = {};
        bool const ours = ::lstat(p.c_str(), &info) == 0 && S_ISDIR(info.st_mode) && info.st_uid == ::getuid() &&
                          (info.st_mode & 077) == 0;
        require(ours, [&] {
            return Error(p + ": not a directory that only this user can enter (needed for sockets).", Exit::security);
        });
    }
    return path;
}

}  // namespace

Participant::Session::Session(JoinOptions given)
    : options(std::move(given)),
      loaded(load_scene(options.scene, options.overrides)),
      scene(loaded.scene),
      self(require_member(scene, options.name)),
      status(make_status(options, lock))
{
    status->pid = ::getpid();
    status->phase = Phase::preparing;
    greetings.resize(scene.participants.size());
    said_bye.resize(scene.participants.size());
    greetings[static_cast<std::size_t>(self)].nonce = std::random_device{}() | std::uint64_t{std::random_device{}()}
                                                                                   << 32;
    for (std::size_t e = 0; e < scene.edges.size(); ++e) {
        Edge const& edge = scene.edges[e];
        auto const& spec = scene.data[static_cast<std::size_t>(edge.data)];
        if (edge.to == self) in.emplace_back(edge, static_cast<int>(e), spec, scene.dimension);
        if (edge.from == self)
            out.push_back({.edge = edge,
                           .number = static_cast<int>(e),
                           .encoder = FrameEncoder(spec, scene.dimension, static_cast<std::uint32_t>(e))});
    }
}

std::string Participant::Session::where() const
{
    return fmt::format("window {} of {} (t = {:.6g} s)", status->window.load(), window_count, status->time.load());
}

Error Participant::Session::lost_peer(int peer) const
{
    return Error(
        fmt::format("participant \"{}\" ended, or was silent for {} s, while \"{}\" was in {}. Look at its log.",
                    scene.participants[static_cast<std::size_t>(peer)].name, scene.silence_timeout, options.name,
                    where()),
        Exit::peer_died);
}

void Participant::Session::book(Activity activity)
{
    auto const now = Clock::now();
    auto& account = activity == Activity::compute ? status->compute_ns
                    : activity == Activity::wait  ? status->wait_ns
                                                  : status->exchange_ns;
    account.fetch_add((now - mark_).count(), std::memory_order_relaxed);
    auto const since_boot = [](Clock::time_point t) {
        return std::chrono::duration<double>(t.time_since_epoch()).count();
    };
    if (trace)
        trace->add(static_cast<std::uint64_t>(status->window.load(std::memory_order_relaxed)), activity,
                   since_boot(mark_), since_boot(now));
    mark_ = now;
}

void Participant::Session::connect()
{
    std::vector<std::string> names;
    for (auto const& p : scene.participants) names.push_back(p.name);
    status->phase = Phase::connecting;
    if (names.size() > 1) {
        Members const members{names, self};
        if (options.transport)
            transport = std::move(options.transport);
        else if (scene.transport == TransportKind::mpi)
            transport = make_mpi_transport(members);
        else
            transport = make_zmq_transport(
                members, {.directory = scene.address.empty() ? socket_directory(options.directory) : "",
                          .address = scene.address,
                          .silence = in_milliseconds(scene.silence_timeout)});
        meet_all();
        transport->settle();
    }
    window_length = choose_window(scene, greetings);
    require(scene.end / window_length < 1e12, [&] {
        return Error(fmt::format("{}: {} s in windows of {} s are more than 1e12 windows. Take longer ones.",
                                 scene.file.string(), scene.end, window_length));
    });
    window_count = static_cast<std::int64_t>(std::ceil(scene.end / window_length - 1e-9));
    for (Greeting const& g : greetings) session = XXH3_64bits_withSeed(&g.nonce, sizeof g.nonce, session);
    std::vector<InEdge> terms;
    for (auto const& channel : in) terms.push_back(channel.terms);
    schedule.emplace(terms, window_count);
    trace = std::make_unique<Trace>(options.name);
    status->windows = window_count;
    status->phase = Phase::running;
    mark_ = Clock::now();
}

void Participant::Session::handle(Transport::Incoming const& incoming)
{
    auto const& peer_name = scene.participants[static_cast<std::size_t>(incoming.peer)].name;
    Header const header = open_message(incoming.message.bytes, peer_name);
    if (header.kind == MessageKind::hello) return handle_greeting(incoming.peer, text_of(incoming.message.bytes));
    if (header.kind == MessageKind::abort) {
        consequence = true;
        throw Error(fmt::format("participant \"{}\" stopped in window {}: {}", peer_name, header.frame,
                                text_of(incoming.message.bytes)),
                    Exit::peer_died);
    }
    // A peer that met everybody first may send its first frame before we have met everybody: then no session is agreed.
    require(session == 0 || header.session == session, [&] {
        return Error("message from \"" + peer_name + "\" of another run. End what is left of it.", Exit::protocol);
    });
    if (header.kind == MessageKind::bye) {
        said_bye[static_cast<std::size_t>(incoming.peer)] = true;
        return;
    }
    if (header.kind == MessageKind::credit) {
        for (auto& channel : out)
            if (channel.number == static_cast<int>(header.edge) && channel.edge.to == incoming.peer)
                channel.used = std::max(channel.used, header.frame);
        return;
    }
    for (auto& channel : in)
        if (channel.number == static_cast<int>(header.edge) && channel.edge.from == incoming.peer)
            return channel.arrive(header, incoming.message.bytes, peer_name);
    throw Error("frame from \"" + peer_name + "\" on an edge that the scene does not have.", Exit::protocol);
}

void Participant::Session::send(int peer, std::span<std::byte const> bytes, Clock::time_point deadline)
{
    while (!transport->try_send(peer, bytes)) {  // the receiver is slower: take in what has come meanwhile
        book(Activity::exchange);
        if (auto incoming = transport->receive(milliseconds(1))) handle(*incoming);
        book(Activity::wait);
        if (transport->lost(peer)) {
            consequence = true;
            throw lost_peer(peer);
        }
        require(Clock::now() < deadline,
                [&] { return Error("no room to send within the time allowed.", Exit::timeout); });
    }
}

//! Waits while the receiver is more than `frames_ahead` behind.
void Participant::Session::await_credit(OutChannel& channel, std::int64_t frame)
{
    int const to = channel.edge.to;
    while (frame - channel.used > frames_ahead && !said_bye[static_cast<std::size_t>(to)]) {
        book(Activity::exchange);
        auto const incoming = transport->receive(patience);
        book(Activity::wait);
        if (incoming)
            handle(*incoming);
        else if (transport->lost(to)) {
            consequence = true;
            throw lost_peer(to);
        }
    }
}

void Participant::Session::send_frames(std::int64_t frame)
{
    for (auto& channel : out) {
        auto const& to = scene.participants[static_cast<std::size_t>(channel.edge.to)].name;
        require(channel.written, [&] {
            return Error("participant \"" + options.name + "\" wrote nothing to \"" + to + "\" before " + where() +
                             " (a state is needed at the start and at the end of every window).",
                         Exit::internal);
        });
        if (needs_credit(scene, channel.edge)) await_credit(channel, frame);
        channel.frame.index = frame;
        channel.frame.time = static_cast<double>(frame) * window_length;
        auto const bytes = channel.encoder.encode(channel.frame, session, options.name);
        bytes_sent += static_cast<std::int64_t>(bytes.size());
        send(channel.edge.to, bytes, Clock::time_point::max());
        channel.written = false;
    }
}

void Participant::Session::await_frame(int edge)
{
    auto& channel = in[static_cast<std::size_t>(edge)];
    bool seen_lost = false;
    while (channel.pending.empty()) {
        book(Activity::exchange);
        auto const incoming = transport->receive(patience);
        book(Activity::wait);
        if (incoming) {
            handle(*incoming);
            continue;
        }
        require(!said_bye[static_cast<std::size_t>(channel.edge.from)], [&] {
            return Error(fmt::format("participant \"{}\" left its run early; \"{}\" still needs its frames in {}.",
                                     scene.participants[static_cast<std::size_t>(channel.edge.from)].name, options.name,
                                     where()),
                         Exit::peer_died);
        });
        if (!transport->lost(channel.edge.from)) continue;
        if (seen_lost) {  // whatever it sent before it ended has been read by now
            consequence = true;
            throw lost_peer(channel.edge.from);
        }
        seen_lost = true;
    }
    auto const number = channel.pending.front().index;
    require(schedule->received(edge, number), [&] {
        return Error(fmt::format("frame {} from \"{}\" came out of turn in {}: one was lost or doubled.", number,
                                 scene.participants[static_cast<std::size_t>(channel.edge.from)].name, where()),
                     Exit::protocol);
    });
    channel.take_next();
    if (!needs_credit(scene, channel.edge)) return;
    auto const credit =
        encode_text(MessageKind::credit, session, number, "", static_cast<std::uint32_t>(channel.number));
    send(channel.edge.from, credit, Clock::time_point::max());
}

bool Participant::Session::advance(Window& window)
{
    if (computing) {
        book(Activity::compute);
        schedule->computed();
        computing = false;
    }
    for (;;) {
        Action const action = schedule->next();
        status->window = action.window;
        status->time = static_cast<double>(action.window) * window_length;
        if (action.kind == Action::Kind::finish) {
            book(Activity::exchange);
            return false;
        }
        if (action.kind == Action::Kind::send) {
            send_frames(action.frame);
            schedule->sent();
        } else if (action.kind == Action::Kind::await) {
            await_frame(action.edge);
        } else {
            double const begin = static_cast<double>(action.window) * window_length;
            double const end = static_cast<double>(action.window + 1) * window_length;
            bool const last = action.window + 1 == window_count;
            auto due = [&](double interval) {  // at the first window end at or after each multiple of the interval
                if (interval <= 0 || last) return last;
                return std::floor(end / interval + 1e-9) > std::floor(begin / interval + 1e-9);
            };
            window = {action.window, begin, end, window_length, due(scene.output_interval), due(scene.series_interval)};
            book(Activity::exchange);
            computing = true;
            return true;
        }
    }
}

void Participant::Session::leave()
{
    require(schedule && schedule->next().kind == Action::Kind::finish, [&] {
        return Error(
            "participant \"" + options.name + "\" left its loop over the windows before their end, in " + where() + ".",
            Exit::internal);
    });
    if (!transport) return;
    auto const bytes = encode_text(MessageKind::bye, session, window_count, "");
    auto const deadline = Clock::now() + in_milliseconds(scene.connect_timeout);
    said_bye[static_cast<std::size_t>(self)] = true;
    for (int p = 0; p < static_cast<int>(said_bye.size()); ++p)
        if (p != self) send(p, bytes, deadline);
    auto lost_twice = std::vector<int>(said_bye.size());
    for (std::size_t p = 0; p < said_bye.size(); ++p)
        while (!said_bye[p]) {
            auto const incoming = transport->receive(patience);
            if (incoming)
                handle(*incoming);
            else if (transport->lost(static_cast<int>(p)) && ++lost_twice[p] > 1) {
                consequence = true;
                throw lost_peer(static_cast<int>(p));
            }
        }
    book(Activity::wait);
}

void Participant::Session::tell_peers(std::string const& why) noexcept
{
    if (!transport || consequence) return;
    try {
        auto const bytes = encode_text(MessageKind::abort, session, status->window.load(), why);
        for (int p = 0; p < static_cast<int>(greetings.size()); ++p)
            if (p != self) (void)transport->try_send(p, bytes);
    } catch (...) {  // the run is over in any case; what went wrong first is what gets reported
    }
}

void Participant::Session::write_summary(int exit) const
{
    auto const in_seconds = [](std::int64_t ns) { return static_cast<double>(ns) * 1e-9; };
    auto const& spec = scene.participants[static_cast<std::size_t>(self)];
    nlohmann::ordered_json const summary = {
        {"name", spec.name},
        {"solver", spec.solver.empty() ? spec.command.at(0) : spec.solver},
        {"exit", exit},
        {"windows", status->window.load()},
        {"window_seconds", window_length},
        {"compute_seconds", in_seconds(status->compute_ns)},
        {"wait_seconds", in_seconds(status->wait_ns)},
        {"exchange_seconds", in_seconds(status->exchange_ns)},
        {"wall_seconds", std::chrono::duration<double>(Clock::now() - start_).count()},
        {"bytes_sent", bytes_sent},
        {"facts", facts},
        {"warnings", warnings},
        {"skipped", skipped}};
    auto const base = options.directory / ".sluice" / spec.name;
    write_atomically(base.string() + ".json", summary.dump(1, ' ', false, nlohmann::json::error_handler_t::replace));
    std::string effective;
    for (auto const& [path, value] : loaded.diagnostics->effective) effective += path + " = " + value + "\n";
    write_atomically(base.string() + ".config", effective);
    if (trace) trace->write(base.string() + ".trace.json");
}

}  // namespace sluice
