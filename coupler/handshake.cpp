#include <fmt/format.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

#include <cmath>
#include <cstdio>
#include <sstream>

#include "coupler/session.hpp"

namespace sluice {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

bool divides(double step, double window)
{
    double const ratio = window / step;
    return ratio > 0.5 && std::abs(ratio - std::round(ratio)) < 1e-6 * ratio;
}

}  // namespace

std::string difference(std::string const& here, std::string const& there)
{
    std::istringstream a(here), b(there);
    for (std::string x, y;;) {
        bool const more_a = static_cast<bool>(std::getline(a, x)), more_b = static_cast<bool>(std::getline(b, y));
        if (!more_a && !more_b) return "nothing that this version compares";
        if (x != y || more_a != more_b)
            return "\"" + (more_a ? x : "nothing") + "\" here, \"" + (more_b ? y : "nothing") + "\" there";
    }
}

double choose_window(Scene const& scene, std::vector<Greeting> const& greetings)
{
    double exact = 0, bound = 0;
    for (Greeting const& g : greetings) {
        if (g.window <= 0) continue;
        if (g.exact)
            exact = std::max(exact, g.window);
        else
            bound = bound == 0 ? g.window : std::min(bound, g.window);
    }
    double const window = scene.window.value_or(exact > 0 ? exact : std::min(bound, scene.end));
    require(window > 0, [&] {
        return Error(scene.file.string() +
                     ": time.window is auto, but no participant proposes a length. Give it in s.");
    });
    auto const members = members_of(scene);
    for (std::size_t m = 0; m < greetings.size(); ++m)
        require(!greetings[m].exact || divides(greetings[m].window, window), [&] {
            return Error(fmt::format("{}: time.window = {} s is not a multiple of the step of \"{}\" ({} s). Use auto.",
                                     scene.file.string(), window, name_of(scene, members[m]), greetings[m].window));
        });
    return window;
}

namespace {

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

bool is_under_mpirun()
{
    return std::getenv("OMPI_COMM_WORLD_SIZE") != nullptr;
}

bool is_mpi(Scene const& scene, std::size_t members)
{
    bool const everybody = is_under_mpirun() && std::getenv("OMPI_COMM_WORLD_SIZE") == std::to_string(members);
    return scene.transport == TransportKind::mpi || (scene.transport == TransportKind::automatic && everybody);
}

//! The transport that the scene asks for. `automatic`: MPI when one mpirun has started everybody, else ZeroMQ, and
//! shared memory between those on one host.
std::unique_ptr<Transport> open_transport(Scene const& scene, std::vector<Member> const& who, Members const& members,
                                          std::filesystem::path const& directory)
{
    auto const kind = scene.transport;
    if (is_mpi(scene, who.size())) return make_mpi_transport(members);
    Network network{.address = scene.address,
                    .port = scene.port,
                    .keys = scene.keys,
                    .silence = in_milliseconds(scene.silence_timeout)};
    if (scene.port > 0)
        for (auto const& member : who)
            network.hosts.push_back(scene.participants[static_cast<std::size_t>(member.participant)].host);
    else
        network.directory = socket_directory(directory);
    if (kind == TransportKind::zmq) return make_zmq_transport(members, network);
    return make_shm_transport(members, network);
}

//! How long to look for a greeting before connections and pages are looked at again: short while all are about to come,
//! a twentieth of the time waited later, so that a long wait costs next to nothing.
milliseconds patience_after(Clock::duration waited)
{
    return std::clamp(std::chrono::duration_cast<milliseconds>(waited / 20), milliseconds(1), milliseconds(200));
}

}  // namespace

void begin_mpi_early(Scene const& scene)
{
    if (is_mpi(scene, members_of(scene).size())) start_mpi();
}

void Participant::Session::connect()
{
    status->phase = Phase::connecting;
    mine().can_store = static_cast<bool>(save);
    mine().columns = reads;
    require(!group || save, [&] {
        return Error("participant \"" + name_of_member(self) +
                         "\" is in an implicit group, but its solver does not keep its state (needed: "
                         "Participant::keeps()).",
                     Exit::config);
    });
    if (!options.given) {
        keep_config();
        find_checkpoint();
    }
    join();
    if (!options.given) trace = std::make_unique<Trace>(name_of_member(self));
    if (!options.given && std::getenv(record_frames)) {
        recording = std::make_unique<Recording>(options.directory / "recordings" / (name_of_member(self) + ".rec"),
                                                scene.hash, scene.canonical);
        recording->append(recorded_window, 0, std::as_bytes(std::span(&window_length, 1)));
    }
}

void Participant::Session::join()
{
    if (members.size() > 1) {
        Members const everybody{names, self};
        transport = options.transport ? std::move(options.transport)
                                      : open_transport(scene, members, everybody, options.directory);
        meet_all();
        transport->settle();
    }
    agree_on_checkpoint();
    start_pace();
    for (Greeting const& g : greetings) session = XXH3_64bits_withSeed(&g.nonce, sizeof g.nonce, session);
    open_channels();
    resume();
    std::vector<InEdge> terms;
    for (auto const& channel : in) terms.push_back(channel.terms);
    schedule.emplace(terms, group != nullptr, std::max<std::int64_t>(0, mine().resumes));
    open_group();
    status->phase = Phase::running;
    mark_ = Clock::now();
    looked_ = now();
    take_early();
}

void Participant::Session::take_early()
{
    for (auto const& incoming : std::exchange(early_, {})) handle(incoming);
}

std::string Participant::Session::command_of(int member) const
{
    auto const& who = members[static_cast<std::size_t>(member)];
    auto const& spec = scene.participants[static_cast<std::size_t>(who.participant)];
    std::string text = spec.solver;
    for (auto const& word : spec.command) text += (text.empty() ? "" : " ") + word;
    text += " " + scene.file.string() + " --as " + spec.name + " --out " + options.directory.string();
    if (spec.ranks > 1) text += " --rank " + std::to_string(who.rank);
    if (options.resume) text += " --resume";
    for (auto const& change : options.overrides) text += " --set " + change;
    return text;
}

//! A greeting says who we are and, once we have read the other's, that we have: `knows`, its nonce. Two have met when
//! each has read that of the other. One greeting each way would not do: the process that read ours may be gone since,
//! and another one have come in its place.
void Participant::Session::greet(int member)
{
    auto const& known = greetings[static_cast<std::size_t>(member)];
    auto& answered = answered_[static_cast<std::size_t>(member)];
    if (answered == known.nonce) return;
    auto const& g = mine();
    nlohmann::json hello = {{"name", name_of_member(self)}, {"process", g.process},
                            {"knows", known.nonce},         {"nonce", g.nonce},
                            {"window", g.window},           {"exact", g.exact},
                            {"can_store", g.can_store},     {"resumes", g.resumes},
                            {"scene", scene.hash},          {"canonical", scene.canonical}};
    if (g.box) hello["box"] = {g.box->min, g.box->max};
    for (auto const& [edge, mask] : g.columns) hello["columns"][std::to_string(edge)] = mask;
    auto const text = hello.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    if (transport->try_send(member, encode_text({.kind = MessageKind::hello}, text))) answered = known.nonce;
}

//! Whether a peer's process on this host is alive and busy: before its first window, e.g. settling a packing, or in a
//! window while others already go back.
bool Participant::Session::is_busy(int member) const
{
    if (options.given) return false;
    MappedStatus const page(status_file(options.directory, name_of_member(member)), MappedStatus::Mode::open);
    if (!page || page->pid <= 0 || ::kill(page->pid, 0) != 0) return false;
    return page->phase == Phase::preparing || (page->phase == Phase::running && scene.restart_on_death);
}

//! Whether a peer's process on this host has ended well.
bool Participant::Session::is_done(int member) const
{
    if (options.given) return false;
    MappedStatus const page(status_file(options.directory, name_of_member(member)), MappedStatus::Mode::open);
    return page && page->phase == Phase::done;
}

//! Who has not come, with what is known about why, and the commands that start them.
std::pair<std::string, std::string> Participant::Session::absent(std::vector<int> const& who) const
{
    std::string list, commands;
    for (int m : who) {
        auto const trouble = transport->trouble(m);
        list +=
            (list.empty() ? "\"" : ", \"") + name_of_member(m) + "\"" + (trouble.empty() ? "" : " (" + trouble + ")");
        commands += "\n    " + command_of(m);
    }
    return {list, commands};
}

void Participant::Session::meet_all()
{
    auto start = transport->now();
    auto const begin = start;
    auto next_word = start + seconds(5);
    auto next_look = start;
    for (;;) {
        std::vector<int> missing;
        bool busy = false;
        bool const look = transport->now() >= next_look;  // at others' pages: files
        for (int m = 0; m < static_cast<int>(greetings.size()); ++m) {
            auto const at = static_cast<std::size_t>(m);
            if (m == self) continue;
            if (transport->lost(m)) {  // it may be started again
                greetings[at] = {};
                answered_[at].reset();
            }
            greet(m);
            if (greetings[at].knows_us && answered_[at] == greetings[at].nonce) continue;
            missing.push_back(m);
            busy = busy || (look && is_busy(m));
        }
        if (missing.empty()) return;
        auto const now = transport->now();
        if (look) next_look = now + milliseconds(100);
        if (busy) start = now;
        require(now - start < in_milliseconds(scene.connect_timeout), [&] {
            auto const [who, commands] = absent(missing);
            return Error(fmt::format("participant \"{}\": {} did not come within {} s. Start with:{}",
                                     name_of_member(self), who, scene.connect_timeout, commands),
                         Exit::timeout);
        });
        if (now > next_word) {
            auto const [who, commands] = absent(missing);
            std::fprintf(stderr, "%s: waiting for %s; start with:%s\n", name_of_member(self).c_str(), who.c_str(),
                         commands.c_str());
            next_word += seconds(5);
        }
        if (auto const incoming = transport->receive(patience_after(now - begin))) handle(*incoming);
    }
}

void Participant::Session::handle_greeting(int member, std::string const& text)
{
    auto const& peer_name = name_of_member(member);
    auto const hello = nlohmann::json::parse(text, nullptr, false);
    auto const refuse_unless = [&](bool ok) {
        require(ok, [&] {
            return Error("greeting from \"" + peer_name + "\" cannot be read. Do all participants run the same Sluice?",
                         Exit::protocol);
        });
    };
    refuse_unless(hello.is_object());
    for (auto const* key : {"scene", "nonce", "knows", "process", "resumes"})  // another number need not fit
        refuse_unless(!hello.contains(key) || hello[key].is_number_integer());
    Greeting g;
    std::string name, canonical;
    std::uint64_t hash = 0;
    try {
        name = hello.value("name", "");
        canonical = hello.value("canonical", "");
        hash = hello.value("scene", std::uint64_t{0});
        g = {.nonce = hello.value("nonce", std::uint64_t{0}),
             .knows_us = hello.value("knows", std::uint64_t{0}) == mine().nonce,
             .process = hello.value("process", 0),
             .window = hello.value("window", 0.0),
             .exact = hello.value("exact", false),
             .can_store = hello.value("can_store", false),
             .resumes = hello.value("resumes", std::int64_t{-1})};
        if (hello.contains("box")) {
            auto const corners = hello["box"].get<std::array<std::array<double, 3>, 2>>();
            g.box = Box{corners[0], corners[1]};
        }
        if (hello.contains("columns"))
            for (auto const& [edge, mask] : hello["columns"].items()) {
                refuse_unless(mask.is_number_integer());
                g.columns[std::stoi(edge)] = mask;
            }
    } catch (std::exception const&) {  // a value of another type
        refuse_unless(false);
    }
    refuse_unless(name == peer_name);
    require(hash == scene.hash && canonical == scene.canonical, [&] {
        return Error("participants \"" + name_of_member(self) + "\" and \"" + peer_name + "\" have different scenes: " +
                         difference(scene.canonical, canonical) + ". Give both the same file and the same --set.",
                     Exit::protocol);
    });
    auto& known = greetings[static_cast<std::size_t>(member)];
    if (may_go_back() && g.nonce != known.nonce)
        stop_because(Error(fmt::format("participant \"{}\" began anew while \"{}\" was in {}.", peer_name,
                                       name_of_member(self), where()),
                           Exit::peer_died));
    require(session == 0 || g.nonce == known.nonce, [&] {
        return Error("participant \"" + peer_name +
                         "\" was started again while its run went on. End what is left of it, and start all of them.",
                     Exit::protocol);
    });
    if (!g.knows_us && answered_[static_cast<std::size_t>(member)] == g.nonce)
        answered_[static_cast<std::size_t>(member)].reset();  // that greeting did not reach it
    known = std::move(g);
    if (session != 0) late_greetings_.push_back(member);  // not now: a frame may be half written into the room for it
}

void Participant::Session::answer_late_greetings()
{
    for (int const member : std::exchange(late_greetings_, {})) greet(member);
}

}  // namespace sluice
