#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <new>

#include "coupler/base/window_line.hpp"
#include "coupler/command_line.hpp"
#include "coupler/session.hpp"

namespace sluice {

bool Window::due(double interval) const
{
    if (interval <= 0 || last) return last;
    return std::floor(end / interval + 1e-9) > std::floor(begin / interval + 1e-9);
}

std::int64_t Window::steps(double longest) const
{
    return std::max<std::int64_t>(1, static_cast<std::int64_t>(std::ceil(length / longest - 1e-9)));
}

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
    return session_->loaded.configs[static_cast<std::size_t>(session_->participant)];
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
        if ((outgoing ? edge.from : edge.to) != session.participant) continue;
        if (std::find(known.begin(), known.end(), data) != known.end()) continue;
        auto problem = edge.place;
        problem.text = edge.path + " = " + data + ": \"" + session.options.name + "\" cannot " +
                       (outgoing ? "send" : "take") + " it (" + (outgoing ? "sends: " : "takes: ") +
                       (list.empty() ? "nothing" : list) + ").";
        session.loaded.diagnostics->problems.push_back(problem);
    }
}

Error no_such_edge(std::string const& name, char const* does, std::string_view data, char const* where,
                   std::string_view partner)
{
    return Error("participant \"" + name + "\" " + does + " " + std::string(data) + where + std::string(partner) +
                     "\", but the scene has no such coupling.",
                 Exit::internal);
}

//! The names at the far end of the edges that carry `data` and have this participant at the near end.
std::vector<std::string> partners(Participant::Session const& session, std::string_view data, int Edge::*near,
                                  int Edge::*far)
{
    std::vector<std::string> names;
    for (Edge const& edge : session.scene.edges)
        if (edge.*near == session.participant && session.scene.data[static_cast<std::size_t>(edge.data)].name == data)
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

Rotation const* Participant::rotation()
{
    auto& problems = session_->loaded.diagnostics->problems;
    std::erase_if(problems, [&](Problem const& p) { return p.text == session_->unasked_rotation().text; });
    return session_->scene.rotation ? &*session_->scene.rotation : nullptr;
}

void Participant::propose_window(double seconds, bool exact)
{
    session_->mine().window = seconds;
    session_->mine().exact = exact;
    if (checking() && seconds > 0) std::printf("%s\n", to_text(WindowLine{seconds, exact}).c_str());
}

void Participant::reads(std::string_view data, std::vector<std::string> const& columns)
{
    for (auto& channel : session_->in) {
        if (channel.spec.name != data || channel.terms.inside) continue;  // a group iterates on all columns
        std::uint32_t mask = 0;
        for (auto const& wanted : columns) {
            auto const& all = channel.spec.columns;
            auto const at = std::find_if(all.begin(), all.end(), [&](auto const& c) { return c.name == wanted; });
            require(at != all.end(), [&] {
                return Error("participant \"" + name() + "\" reads " + channel.spec.name + "." + wanted +
                                 ", which is no column of it.",
                             Exit::internal);
            });
            mask |= 1u << (at - all.begin());
        }
        session_->reads[channel.number] = mask;
        for (auto& origin : channel.origins)
            origin.decoder = FrameDecoder(channel.spec, session_->scene.dimension, mask);
    }
}

void Participant::covers(Box const& box)
{
    session_->mine().box = box;
}

void Participant::keeps(std::function<void(State&)> save, std::function<void(State const&)> restore)
{
    session_->save = std::move(save);
    session_->restore = std::move(restore);
}

bool Participant::resumes() const
{
    return session_->options.resume;
}

bool Participant::went_back()
{
    return std::exchange(session_->went_back, false);
}

double Participant::resumed_at() const
{
    return session_->resumed_at;
}

void Participant::next_window(double seconds)
{
    session_->set_next_window(seconds);
}

void Participant::end_run(std::string const& why)
{
    session_->end_run(why);
}

void Participant::request_checkpoint()
{
    session_->status->request.fetch_or(static_cast<std::int32_t>(Request::checkpoint));
}

int Participant::rank() const
{
    return session_->options.rank;
}

int Participant::ranks() const
{
    return session_->scene.participants[static_cast<std::size_t>(session_->participant)].ranks;
}

void Participant::write(std::string_view to, std::string_view data, std::span<std::int64_t const> ids,
                        std::vector<std::span<double const>> const& columns)
{
    auto& s = *session_;
    for (auto& channel : s.out) {
        auto const& spec = channel.spec;
        if (spec.name != data || s.scene.participants[static_cast<std::size_t>(channel.edge.to)].name != to) continue;
        require(columns.size() == spec.columns.size(), [&] {
            return Error("participant \"" + name() + "\" wrote " + std::to_string(columns.size()) + " columns of " +
                             spec.name + " (it has " + std::to_string(spec.columns.size()) + ").",
                         Exit::internal);
        });
        for (std::size_t c = 0; c < columns.size(); ++c) {
            auto const width = static_cast<std::size_t>(components(spec.columns[c].shape, s.scene.dimension));
            require(columns[c].size() == ids.size() * width, [&] {
                return Error("participant \"" + name() + "\" wrote " + std::to_string(columns[c].size()) +
                                 " numbers of " + spec.name + "." + spec.columns[c].name + " (needed: " +
                                 std::to_string(width) + " for each of " + std::to_string(ids.size()) + " points).",
                             Exit::internal);
            });
        }
        return s.write(channel, ids, columns);
    }
    throw no_such_edge(name(), "writes", data, " to \"", to);
}

Samples Participant::read(std::string_view from, std::string_view data, Window const& window)
{
    auto& s = *session_;
    for (auto& channel : s.in)
        if (channel.spec.name == data && s.scene.participants[static_cast<std::size_t>(channel.edge.from)].name == from)
            return {channel, window};
    throw no_such_edge(name(), "reads", data, " from \"", from);
}

void Participant::write_values(std::string_view to, std::string_view data, std::span<double const> values)
{
    static constexpr std::int64_t one_point[] = {0};
    std::vector<std::span<double const>> columns;
    for (auto const& channel : session_->out) {
        if (channel.spec.name != data) continue;
        columns.clear();
        std::size_t at = 0;
        for (auto const& column : channel.spec.columns) {
            auto const width = static_cast<std::size_t>(components(column.shape, scene().dimension));
            columns.push_back(values.subspan(std::min(at, values.size()), std::min(width, values.size() - at)));
            at = std::min(at + width, values.size());
        }
        break;
    }
    write(to, data, one_point, columns);
}

std::vector<double> Participant::read_values(std::string_view from, std::string_view data, Window const& window)
{
    std::vector<double> values;
    for (auto const& column : read(from, data, window).columns(window.end))
        values.insert(values.end(), column.begin(), column.end());
    return values;
}

bool Participant::accepted(Window const&)
{
    return session_->settle();
}

std::vector<std::string> Participant::receivers(std::string_view data) const
{
    return partners(*session_, data, &Edge::from, &Edge::to);
}

std::vector<std::string> Participant::senders(std::string_view data) const
{
    return partners(*session_, data, &Edge::to, &Edge::from);
}

std::string Participant::sender(std::string_view data) const
{
    auto const all = senders(data);
    if (all.size() > 1)
        throw Error(name() + ": " + std::string(data) + " from " + all[0] + " and " + all[1] +
                    " (at most one participant may send it).");
    return all.empty() ? "" : all.front();
}

Windows Participant::windows()
{
    session_->loaded.diagnostics->throw_if_any();  // of a solver without configuration
    session_->connect();
    return Windows(*session_);
}

Windows::Iterator::Iterator(Participant::Session& session) : session_(&session)
{
    ++*this;
}

Windows::Iterator& Windows::Iterator::operator++()
{
    require_log();
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

int Participant::finish()
{
    auto& s = *session_;
    s.leave();
    auto const exit = static_cast<int>(!s.stopped                 ? Exit::ok
                                       : s.status->can_store != 0 ? Exit::stopped
                                                                  : Exit::interrupted);
    s.write_summary(exit);
    s.status->exit = exit;
    s.status->phase = Phase::done;
    return exit;
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
    if (s.transport && s.transport->kind() == "mpi" && !s.options.check) {
        std::fprintf(stderr, "%s: %s\n", s.name_of_member(s.self).c_str(), error.what());
        s.transport->give_up(static_cast<int>(error.exit()));
    }
}

std::string Participant::last_words(Error const& error) const
{
    auto const& s = *session_;
    std::string const why = error.what();
    if (s.status->windows <= 0 || why.find("(t = ") != why.npos) return why;
    return fmt::format("participant \"{}\" stopped in {}, process {}: {}", s.name_of_member(s.self), s.where(),
                       s.status->pid.load(), why);
}

namespace {

int solve_and_finish(Participant& self, std::function<void(Participant&)> const& solve)
{
    try {
        solve(self);
        if (self.checking()) return 0;
        return self.finish();
    } catch (Error const& e) {
        self.fail(e);
        std::fprintf(stderr, "%s\n", self.last_words(e).c_str());
        return static_cast<int>(e.exit());
    } catch (std::bad_alloc const&) {
        Error const e("participant \"" + self.name() + "\": out of memory. Make the scene smaller.", Exit::io);
        self.fail(e);
        std::fprintf(stderr, "%s\n", self.last_words(e).c_str());
        return static_cast<int>(e.exit());
    } catch (std::exception const& e) {
        Error const internal("participant \"" + self.name() + "\": " + e.what() + " (a bug of ours).", Exit::internal);
        self.fail(internal);
        std::fprintf(stderr, "%s\n", self.last_words(internal).c_str());
        return static_cast<int>(Exit::internal);
    }
}

}  // namespace

int run(int argc, char** argv, std::function<void(Participant&)> const& solve)
{
    JoinOptions options;
    if (int const code = parse_command_line(argc, argv, options); code >= 0) return code;
    heed_signals();
    write_log_by_lines();
    try {
        Participant self(std::move(options));
        return exit_for_launcher(solve_and_finish(self, solve));
    } catch (Error const& e) {  // the scene itself cannot be read
        std::fprintf(stderr, "%s\n", e.what());
        return static_cast<int>(e.exit());
    } catch (std::bad_alloc const&) {  // before there was a participant
        std::fputs("out of memory before the first window (needed: a larger limit, see ulimit -v).\n", stderr);
        return static_cast<int>(Exit::io);
    }
}

}  // namespace sluice
