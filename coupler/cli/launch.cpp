#include "coupler/cli/launch.hpp"

#include <fmt/format.h>
#include <signal.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <thread>

#include "coupler/base/error.hpp"
#include "coupler/cli/post_mortem.hpp"
#include "coupler/cli/restarts.hpp"
#include "coupler/cli/signals.hpp"
#include "coupler/cli/watchdog.hpp"

namespace sluice {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr milliseconds tick{20};
constexpr milliseconds grace{700};          // for the others to say why they stop, after the first has ended
constexpr milliseconds early_grace{200};    // before the first window: who waits for one that died has nothing to say
constexpr milliseconds mpirun_grace{1600};  // mpirun says how a process ended in 0.4 s on an idle machine
constexpr milliseconds term_time{200};      // between SIGTERM and SIGKILL
constexpr milliseconds far_term_time{
    1500};                           // the same for what has to end a process on another host: srun asks its controller
constexpr seconds time_to_stop{15};  // Slurm kills 30 s after its SIGTERM

std::vector<std::string> names_of(std::vector<CrewMember> const& members)
{
    std::vector<std::string> names;
    for (auto const& member : members) names.push_back(member.name);
    return names;
}

//! One run, from start to end.
class Run
{
 public:
    Run(Scene const& scene, std::filesystem::path const& directory, Begin begin, std::string resume,
        UserSignals& signals)
        : crew_{.scene = scene, .directory = directory, .members = members_of_crew(scene), .pages = {}, .jobs = {}},
          resume_(std::move(resume)),
          signals_(signals),
          watchdog_(names_of(crew_.members), scene.window_timeout)
    {
        adopt_orphans();
        crew_.jobs = jobs_of(scene, crew_.members, directory, begin);
        crew_.pages.reserve(crew_.members.size());
        for (auto const& member : crew_.members)
            crew_.pages.emplace_back(status_file(directory, member.name), MappedStatus::Mode::open);
        for (auto& job : crew_.jobs) crew_.start(job, begin == Begin::resumed ? Log::append : Log::replace);
    }

    RunEnding watch(Progress& progress);
    int restarts() const { return restarts_.total(); }

 private:
    bool one_failed();
    RunEnding failed();
    RunEnding well();
    void end_all(Clock::time_point first_failure, std::optional<std::size_t>& root);
    void hear_user();
    RunEnding ended_by_force(std::string const& why);
    std::string look_after_progress(Progress& progress);

    Crew crew_;
    std::string resume_;
    UserSignals& signals_;
    UserSignals::Listening listening_;
    Restarts restarts_;
    Watchdog watchdog_;
    int stop_signal_ = 0;
    std::optional<Clock::time_point> stop_by_ = {};  //!< the run was asked to stop, and is ended at this time
};

bool Run::one_failed()
{
    bool any = false;
    for (auto& job : crew_.jobs) any = crew_.state_of(job) == Crew::State::failed || any;
    return any;
}

//! Ends whatever still runs: first politely, then not. Returns within 2 s of the first failure, 3 s with
//! other hosts. `root`: who was the
//! cause, if that was not known yet.
void Run::end_all(Clock::time_point first_failure, std::optional<std::size_t>& root)
{
    bool const mpirun = std::any_of(crew_.jobs.begin(), crew_.jobs.end(), [](Job const& j) { return j.mpirun; });
    bool const begun = std::any_of(crew_.pages.begin(), crew_.pages.end(),
                                   [](MappedStatus const& page) { return page && page->windows > 0; });
    auto const patience = mpirun ? mpirun_grace : begun ? grace : early_grace;
    bool const far = std::any_of(crew_.jobs.begin(), crew_.jobs.end(), [](Job const& j) { return j.remote; });
    auto const end = patience + (far ? far_term_time : term_time);
    bool asked = false, killed = false;
    while (!crew_.all_ended()) {
        if (!root && !asked) root = root_cause(crew_);  // later, our own signals end them
        auto const since = Clock::now() - first_failure;
        if (!asked && since > patience) {
            asked = true;
            crew_.ask_all_to_end();
        }
        if (!killed && since > end) {
            killed = true;
            crew_.kill_all();
        }
        std::this_thread::sleep_for(tick);
    }
    if (!root && !asked) root = root_cause(crew_);
}

RunEnding Run::failed()
{
    auto root = root_cause(crew_);
    end_all(Clock::now(), root);
    auto verdict = explain(crew_, root);
    if (!restarts_.why_not().empty()) verdict.message += "\n  " + restarts_.why_not();
    return {.exit = verdict.exit, .message = verdict.message};
}

//! All members are done: the end of the run was reached, or it was stopped as asked.
RunEnding Run::well()
{
    std::int32_t exit = 0;
    for (auto const& page : crew_.pages) exit = std::max(exit, page->exit.load());
    RunEnding ending{.exit = exit, .message = {}};
    auto const& page = crew_.pages[0];
    auto const where = fmt::format("before window {} of {} (t = {:.6g} s)", page->window.load(), page->windows.load(),
                                   page->time.load());
    auto const by = stop_signal_ ? std::string(" by ") + ::strsignal(stop_signal_) : std::string();
    if (exit == static_cast<int>(Exit::stopped))
        ending.message = fmt::format("stopped{} {}, with a checkpoint. Go on with: {}", by, where, resume_);
    if (exit == static_cast<int>(Exit::interrupted))
        ending.message = fmt::format(
            "stopped{} {}; without a checkpoint, since not every solver keeps its state: "
            "this run cannot be resumed.",
            by, where);
    return ending;
}

RunEnding Run::ended_by_force(std::string const& why)
{
    auto const where = places_of(crew_);
    crew_.ask_all_to_end();
    std::optional<std::size_t> root = 0;  // we are
    end_all(Clock::now() - mpirun_grace, root);
    return {.exit = static_cast<int>(Exit::interrupted), .message = fmt::format("stopped by {}: {}.", why, where)};
}

//! Signals become requests to the process that paces the run.
void Run::hear_user()
{
    auto* const pacer = crew_.pacer_page();
    auto const ask = [&](Request request) { pacer->request.fetch_or(static_cast<std::int32_t>(request)); };
    if (signals_.take_checkpoint() && pacer) ask(Request::checkpoint);
    int const number = signals_.take_stop();
    if (number == 0) return;
    bool const first = stop_signal_ == 0;
    stop_signal_ = number;
    stop_by_ = Clock::now();
    // before the run there is nothing to wait for; after it the others may still be ending
    if (!first || !pacer || pacer->phase < Phase::running) return;
    ask(Request::stop);
    *stop_by_ += time_to_stop;
}

//! Not empty: the run is to end, since a window takes too long.
std::string Run::look_after_progress(Progress& progress)
{
    auto const finding = watchdog_.look(crew_.pages, Clock::now());
    if (!finding) return {};
    if (finding->fatal) return finding->text;
    progress.clear();
    std::fprintf(stderr, "%s\n", finding->text.c_str());
    return {};
}

RunEnding Run::watch(Progress& progress)
{
    for (;; std::this_thread::sleep_for(tick)) {
        crew_.map_pages();
        hear_user();
        if (stop_by_ && Clock::now() >= *stop_by_) return ended_by_force(::strsignal(stop_signal_));
        if (one_failed()) {
            if (!stop_by_ && restarts_.deal_with(crew_)) continue;
            return failed();
        }
        if (crew_.all_ended() && crew_.all_done()) return well();
        if (auto const why = look_after_progress(progress); !why.empty()) {
            (void)ended_by_force({});
            return {.exit = static_cast<int>(Exit::timeout), .message = why};
        }
        progress.show(crew_.pages);
    }
}

}  // namespace

RunEnding launch(Scene const& scene, std::filesystem::path const& directory, Progress& progress, Begin begin,
                 std::string const& resume, UserSignals& signals)
{
    auto const started = Clock::now();
    RunEnding ending;
    {
        Run run(scene, directory, begin, resume, signals);
        ending = run.watch(progress);
        ending.restarts = run.restarts();
    }
    end_orphans();
    progress.clear();
    ending.wall_seconds = std::chrono::duration<double>(Clock::now() - started).count();
    return ending;
}

}  // namespace sluice
