#include <sys/prctl.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <new>

#include "coupler/session.hpp"

namespace sluice {

Participant::Participant(JoinOptions options) : session_(std::make_unique<Session>(std::move(options))) {}
Participant::Participant(Participant&&) noexcept = default;
Participant::~Participant() = default;

Scene const& Participant::scene() const
{
    return session_->scene;
}
std::string const& Participant::name() const
{
    return session_->options.name;
}
std::filesystem::path const& Participant::directory() const
{
    return session_->options.directory;
}
Reader Participant::config()
{
    return session_->loaded.configs[static_cast<std::size_t>(session_->self)];
}
bool Participant::checking() const
{
    return session_->options.check;
}

namespace {

void refuse_other(Participant::Session& session, bool outgoing, std::vector<std::string> const& known)
{
    std::string list;
    for (auto const& name : known) list += (list.empty() ? "" : ", ") + name;
    for (Edge const& edge : session.scene.edges) {
        auto const& data = session.scene.data[static_cast<std::size_t>(edge.data)].name;
        if ((outgoing ? edge.from : edge.to) != session.self) continue;
        if (std::find(known.begin(), known.end(), data) != known.end()) continue;
        auto problem = edge.place;
        problem.text = edge.path + " = " + data + ": \"" + session.options.name + "\" cannot " +
                       (outgoing ? "send" : "take") + " it (" + (outgoing ? "sends: " : "takes: ") +
                       (list.empty() ? "nothing" : list) + ").";
        session.loaded.diagnostics->problems.push_back(problem);
    }
}

//! The names at the far end of the edges that carry `data` and have this participant at the near end.
std::vector<std::string> partners(Participant::Session const& session, std::string_view data, int Edge::*near,
                                  int Edge::*far)
{
    std::vector<std::string> names;
    for (Edge const& edge : session.scene.edges)
        if (edge.*near == session.self && session.scene.data[static_cast<std::size_t>(edge.data)].name == data)
            names.push_back(session.scene.participants[static_cast<std::size_t>(edge.*far)].name);
    return names;
}

}  // namespace

void Participant::sends(std::vector<std::string> const& data)
{
    refuse_other(*session_, true, data);
}
void Participant::takes(std::vector<std::string> const& data)
{
    refuse_other(*session_, false, data);
}

void Participant::propose_window(double seconds, bool exact)
{
    auto& mine = session_->greetings[static_cast<std::size_t>(session_->self)];
    mine.window = seconds;
    mine.exact = exact;
}

void Participant::write(std::string_view to, std::string_view data, std::span<std::int64_t const> ids,
                        std::vector<std::span<double const>> const& columns)
{
    auto& s = *session_;
    for (auto& channel : s.out) {
        auto const& spec = s.scene.data[static_cast<std::size_t>(channel.edge.data)];
        if (spec.name != data || s.scene.participants[static_cast<std::size_t>(channel.edge.to)].name != to) continue;
        require(columns.size() == spec.columns.size(), [&] {
            return Error("participant \"" + name() + "\" wrote " + std::to_string(columns.size()) + " columns of " +
                             spec.name + " (it has " + std::to_string(spec.columns.size()) + ").",
                         Exit::internal);
        });
        channel.frame.ids.assign(ids.begin(), ids.end());
        channel.frame.columns.resize(columns.size());
        for (std::size_t c = 0; c < columns.size(); ++c) {
            auto const width = static_cast<std::size_t>(components(spec.columns[c].shape, s.scene.dimension));
            require(columns[c].size() == ids.size() * width, [&] {
                return Error("participant \"" + name() + "\" wrote " + std::to_string(columns[c].size()) +
                                 " numbers of " + spec.name + "." + spec.columns[c].name + " (needed: " +
                                 std::to_string(width) + " for each of " + std::to_string(ids.size()) + " points).",
                             Exit::internal);
            });
            channel.frame.columns[c].assign(columns[c].begin(), columns[c].end());
        }
        channel.written = true;
        return;
    }
    throw Error("participant \"" + name() + "\" writes " + std::string(data) + " to \"" + std::string(to) +
                    "\", but the scene has no such coupling.",
                Exit::internal);
}

Samples Participant::read(std::string_view from, std::string_view data, Window const& window)
{
    auto& s = *session_;
    for (auto& channel : s.in) {
        auto const& spec = s.scene.data[static_cast<std::size_t>(channel.edge.data)];
        if (spec.name == data && s.scene.participants[static_cast<std::size_t>(channel.edge.from)].name == from)
            return {channel, window};
    }
    throw Error("participant \"" + name() + "\" reads " + std::string(data) + " from \"" + std::string(from) +
                    "\", but the scene has no such coupling.",
                Exit::internal);
}

std::vector<std::string> Participant::receivers(std::string_view data) const
{
    return partners(*session_, data, &Edge::from, &Edge::to);
}

std::vector<std::string> Participant::senders(std::string_view data) const
{
    return partners(*session_, data, &Edge::to, &Edge::from);
}

Windows Participant::windows()
{
    session_->connect();
    return Windows(*session_);
}

Windows::Iterator::Iterator(Participant::Session& session) : session_(&session)
{
    ++*this;
}

Windows::Iterator& Windows::Iterator::operator++()
{
    done_ = !session_->advance(window_);
    return *this;
}

void Participant::fact(std::string const& name, double value)
{
    session_->facts[name] = value;
}
void Participant::fact(std::string const& name, std::string const& text)
{
    session_->facts[name] = text;
}
void Participant::warn(std::string const& text)
{
    session_->warnings.push_back(text);
}
void Participant::skipped(std::string const& what, std::string const& why, double share)
{
    session_->skipped.push_back({{"what", what}, {"why", why}, {"share", share}});
}
void Participant::note(std::string_view text)
{
    session_->status.note(text);
}

void Participant::finish()
{
    session_->leave();
    session_->write_summary(0);
    session_->status->exit = 0;
    session_->status->phase = Phase::done;
}

void Participant::fail(Error const& error) noexcept
{
    auto& s = *session_;
    s.tell_peers(error.what());
    try {
        if (!s.options.check) s.write_summary(static_cast<int>(error.exit()));
    } catch (...) {  // the disk may be full: the message below still reaches the user
    }
    s.status.fail(error.what(), static_cast<int>(error.exit()), s.consequence);
    bool const mpi = s.transport && s.scene.transport == TransportKind::mpi;
    if (mpi && !s.options.check) {
        std::fprintf(stderr, "%s: %s\n", s.options.name.c_str(), error.what());
        s.transport->give_up(static_cast<int>(error.exit()));
    }
}

namespace {

int parse(int argc, char** argv, JoinOptions& options)
{
    CLI::App app{"A participant of a coupled run. `sluice run SCENE` starts all of them; this starts one by hand."};
    app.add_option("SCENE", options.scene, "the scene (YAML)")->required();
    app.add_option("--as", options.name, "which participant of the scene this process is")->required();
    app.add_option("--out", options.directory, "directory of the run, the same for all participants (runs/SCENE)");
    app.add_option("--set", options.overrides, "path=value: change the scene, the same for all participants")
        ->allow_extra_args(false);
    app.add_flag("--check", options.check, "read and check the configuration, then stop");
    app.set_version_flag("--version", SLUICE_VERSION);
    try {
        app.parse(argc, argv);
    } catch (CLI::ParseError const& e) {
        return app.exit(e) == 0 ? 0 : static_cast<int>(Exit::config);
    }
    if (options.directory.empty()) options.directory = std::filesystem::path("runs") / options.scene.stem();
    return -1;
}

int solve_and_finish(Participant& self, std::function<void(Participant&)> const& solve)
{
    try {
        solve(self);
        if (!self.checking()) self.finish();
        return 0;
    } catch (Error const& e) {
        self.fail(e);
        std::fprintf(stderr, "%s\n", e.what());
        return static_cast<int>(e.exit());
    } catch (std::bad_alloc const&) {
        Error const e("participant \"" + self.name() + "\": out of memory. Make the scene smaller.", Exit::io);
        self.fail(e);
        std::fprintf(stderr, "%s\n", e.what());
        return static_cast<int>(e.exit());
    } catch (std::exception const& e) {
        Error const internal("participant \"" + self.name() + "\": " + e.what() + " (a bug of ours).", Exit::internal);
        self.fail(internal);
        std::fprintf(stderr, "%s\n", internal.what());
        return static_cast<int>(Exit::internal);
    }
}

}  // namespace

int run(int argc, char** argv, std::function<void(Participant&)> const& solve)
{
    JoinOptions options;
    if (int const code = parse(argc, argv, options); code >= 0) return code;
    std::signal(SIGPIPE, SIG_IGN);
    if (std::getenv(parent_death)) ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    try {
        Participant self(std::move(options));
        return solve_and_finish(self, solve);
    } catch (Error const& e) {  // the scene itself cannot be read
        std::fprintf(stderr, "%s\n", e.what());
        return static_cast<int>(e.exit());
    }
}

}  // namespace sluice
