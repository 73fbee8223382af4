#include "coupler/cli/launch.hpp"

#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstring>
#include <optional>
#include <regex>
#include <thread>

#include "coupler/base/error.hpp"
#include "coupler/base/status_page.hpp"
#include "coupler/cli/check.hpp"
#include "coupler/record/atomic_file.hpp"

namespace sluice {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr milliseconds tick{20};
constexpr milliseconds grace{700};  // for the others to say why they stop, after the first has ended
constexpr milliseconds mpirun_time{
    1600};  // mpirun notices a dead process, and says how it ended, in 0.4 s on an idle machine
constexpr milliseconds before_kill{1200};  // after the first has ended: SIGTERM has had 0.5 s

std::atomic<int> asked_to_stop{0};

extern "C" void note_signal(int number)
{
    asked_to_stop = number;
}

class SignalGuard
{
 public:
    SignalGuard()
    {
        struct sigaction action = {};
        action.sa_handler = note_signal;
        ::sigaction(SIGINT, &action, &interrupt_);
        ::sigaction(SIGTERM, &action, &terminate_);
    }
    SignalGuard(SignalGuard const&) = delete;
    SignalGuard& operator=(SignalGuard const&) = delete;
    ~SignalGuard()
    {
        ::sigaction(SIGINT, &interrupt_, nullptr);
        ::sigaction(SIGTERM, &terminate_, nullptr);
    }

 private:
    struct sigaction interrupt_ = {}, terminate_ = {};
};

std::vector<std::string> command(Scene const& scene, ParticipantSpec const& spec,
                                 std::filesystem::path const& directory)
{
    auto argv = program_of(spec);
    argv.insert(argv.end(), {scene.file.string(), "--as", spec.name, "--out", directory.string()});
    for (auto const& change : scene.overrides) argv.insert(argv.end(), {"--set", change});
    return argv;
}

//! One mpirun with every participant as a program of its own.
std::vector<std::string> mpi_command(Scene const& scene, std::filesystem::path const& directory)
{
    std::vector<std::string> argv{"mpirun", "--oversubscribe", "--bind-to", "none"};
    if (::geteuid() == 0) argv.emplace_back("--allow-run-as-root");
    for (std::size_t p = 0; p < scene.participants.size(); ++p) {
        if (p > 0) argv.emplace_back(":");
        argv.insert(argv.end(), {"-np", "1"});
        auto const words = command(scene, scene.participants[p], directory);
        argv.insert(argv.end(), words.begin(), words.end());
    }
    return argv;
}

//! The processes of a run and their status pages.
struct Crew
{
    Scene const& scene;
    std::filesystem::path directory;
    std::vector<Process> processes;   //!< one per participant, or one mpirun
    std::vector<std::string> logs;    //!< of each process
    std::vector<MappedStatus> pages;  //!< one per participant
    bool mpi;
    Clock::time_point started = Clock::now();
    int who = -1;                                //!< which participant under mpirun was gone first
    std::optional<Clock::time_point> gone = {};  //!< when a participant under mpirun was first found gone

    bool all_ended()
    {
        bool all = true;
        for (auto& process : processes) all = process.poll().has_value() && all;
        return all;
    }
    bool is_done(std::size_t p) const { return pages[p] && pages[p]->phase == Phase::done; }
    //! A process ended badly or before its participant was done, or a participant says that it failed.
    bool one_failed()
    {
        bool const mpirun_lost_one = mpi && first_gone();
        for (std::size_t p = 0; p < processes.size(); ++p)
            if (auto const ending = processes[p].poll(); ending && (!ending->well() || (!mpi && !is_done(p))))
                return true;
        for (auto const& page : pages)
            if (page && page->phase == Phase::failed) return true;
        if (mpirun_lost_one && Clock::now() - *gone > mpirun_time) return true;
        return mpi && all_ended() && !all_done();
    }
    //! mpirun: a participant's process is gone though it was not done, or never came. mpirun ends the others and says
    //! how it ended; only if it does not within its time is it our turn.
    bool first_gone()
    {
        if (gone) return true;
        bool const late = Clock::now() - started > std::chrono::duration<double>(scene.connect_timeout);
        for (std::size_t p = 0; p < pages.size() && !gone; ++p)
            if (pages[p] ? !is_done(p) && pages[p]->pid > 0 && ::kill(pages[p]->pid, 0) != 0 : late) {
                gone = Clock::now();
                who = static_cast<int>(p);
            }
        return gone.has_value();
    }
    bool all_done() const
    {
        for (std::size_t p = 0; p < pages.size(); ++p)
            if (!is_done(p)) return false;
        return true;
    }
    void signal_all(int number)
    {
        for (auto& process : processes) process.signal(number);
    }
    void map_pages()
    {
        for (std::size_t p = 0; p < pages.size(); ++p)
            if (!pages[p]) {
                pages[p] = MappedStatus(status_file(directory, scene.participants[p].name), MappedStatus::Mode::open);
            }
    }
};

//! What an earlier run left under the names of this one's results, so that old and new never stand side by side.
void remove_old_results(Scene const& scene, std::filesystem::path const& directory)
{
    std::vector<std::string> names{"series.csv", "summary.json", "archive.h5",
                                   "trace.json", "report.html",  scene.file.stem().string() + ".pvd"};
    for (auto const& spec : scene.participants)
        for (std::string const ending : {".csv", ".pvd", ".h5", ".log"}) names.push_back(spec.name + ending);
    for (auto const& spec : scene.participants)
        for (std::string const ending : {".status", ".json", ".config", ".trace.json"})
            names.push_back(".sluice/" + spec.name + ending);
    for (auto const& name : names) std::filesystem::remove(directory / name);
    for (auto const& spec : scene.participants) std::filesystem::remove_all(directory / spec.name);
}

Crew start(Scene const& scene, std::filesystem::path const& directory)
{
    Crew crew{scene, directory, {}, {}, {}, scene.transport == TransportKind::mpi && scene.participants.size() > 1};
    remove_old_results(scene, directory);
    for (auto const& spec : scene.participants)
        crew.pages.emplace_back(status_file(directory, spec.name), MappedStatus::Mode::open);
    if (crew.mpi) {
        require(!find_executable("mpirun").empty(), [] {
            return Error("transport: mpi needs mpirun, which is not on PATH. Install the package openmpi-bin.",
                         Exit::io);
        });
        crew.logs.push_back((directory / "mpirun.log").string());
        crew.processes.emplace_back(
            mpi_command(scene, directory), crew.logs.back(),
            std::vector<std::pair<std::string, std::string>>{
                {"OMPI_MCA_mpi_yield_when_idle", "1"},
                {"OMPI_MCA_odls_base_sigkill_timeout", "0"},  // else it sleeps 1 s over its dead
                {parent_death, "1"}});
        return crew;
    }
    for (auto const& spec : scene.participants) {
        crew.logs.push_back((directory / (spec.name + ".log")).string());
        crew.processes.emplace_back(command(scene, spec, directory), crew.logs.back());
    }
    return crew;
}

std::string place(MappedStatus const& page)
{
    if (!page || page->phase == Phase::absent) return "before its first window";
    if (page->windows == 0) return "before its first window";
    return fmt::format("in window {} of {} (t = {:.6g} s)", page->window.load(), page->windows.load(),
                       page->time.load());
}

std::string words_of(Ending const& ending)
{
    if (ending.signal != 0)
        return fmt::format("was ended by signal {} ({})", ending.signal, ::strsignal(ending.signal));
    return fmt::format("ended with exit code {}", ending.code);
}

//! How mpirun says that the first of its processes ended.
Ending ending_in(std::filesystem::path const& mpirun_log)
{
    auto const text = read_file(mpirun_log);
    std::smatch m;
    if (std::regex_search(text, m, std::regex("exited on signal (\\d+)"))) return {0, std::stoi(m[1])};
    if (std::regex_search(text, m, std::regex("Signal: [^\n]*\\((\\d+)\\)"))) return {0, std::stoi(m[1])};
    if (std::regex_search(text, m, std::regex("Exit code: *(\\d+)"))) return {std::stoi(m[1]), 0};
    return {1, 0};
}

//! Which participant failed by itself, not because another one did; -1: none said so.
int root_cause(Crew& crew)
{
    for (std::size_t p = 0; p < crew.pages.size(); ++p)
        if (crew.pages[p] && crew.pages[p]->phase == Phase::failed && !crew.pages[p]->consequence)
            return static_cast<int>(p);
    if (crew.mpi) return crew.first_gone() ? crew.who : -1;
    for (std::size_t p = 0; p < crew.processes.size(); ++p) {
        bool const told = crew.pages[p] && (crew.is_done(p) || crew.pages[p]->phase == Phase::failed);
        if (crew.processes[p].poll() && !told) return static_cast<int>(p);
    }
    return -1;
}

RunEnding explain(Crew& crew, int root)
{
    RunEnding ending;
    ending.exit = static_cast<int>(Exit::peer_died);
    for (std::size_t p = 0; p < crew.pages.size() && root < 0; ++p)  // only consequences: the first tells most
        if (crew.pages[p] && crew.pages[p]->phase == Phase::failed) root = static_cast<int>(p);
    if (root < 0) {
        ending.message = "the run ended early. Look at the logs in " + crew.directory.string() + ".";
        return ending;
    }
    auto const at = static_cast<std::size_t>(root);
    auto const& name = crew.scene.participants[at].name;
    auto const& page = crew.pages[at];
    auto const log = crew.logs[crew.mpi ? 0 : at];
    if (page && page->phase == Phase::failed) {
        ending.exit = page->exit;
        ending.message = fmt::format("participant \"{}\" stopped {}: {}", name, place(page), page->message);
        return ending;
    }
    auto const how = words_of(crew.mpi ? ending_in(log) : crew.processes[at].wait());
    ending.message =
        fmt::format("participant \"{}\" {} {}. Its log: {}{}", name, how, place(page), log, last_lines(log, 5));
    return ending;
}

//! Ends whatever still runs: first politely, then not. Returns within 2 s of the first failure.
int end_all(Crew& crew, Clock::time_point first_failure)
{
    int root = -1;
    bool asked = false, killed = false;
    while (!crew.all_ended()) {
        if (root < 0 && !asked) root = root_cause(crew);  // later, our own signals end them
        auto const since = Clock::now() - first_failure;
        if (!asked && since > (crew.mpi ? mpirun_time : grace)) {
            asked = true;
            crew.signal_all(SIGTERM);
        }
        if (!killed && since > (crew.mpi ? mpirun_time + tick : before_kill)) {
            killed = true;
            crew.signal_all(SIGKILL);
        }
        std::this_thread::sleep_for(tick);
    }
    return root < 0 && !asked ? root_cause(crew) : root;
}

RunEnding interrupted(Crew& crew)
{
    int const number = asked_to_stop;
    std::string where;
    for (std::size_t p = 0; p < crew.pages.size(); ++p)
        where += (p ? ", \"" : "\"") + crew.scene.participants[p].name + "\" " + place(crew.pages[p]);
    crew.signal_all(SIGTERM);
    end_all(crew, Clock::now() - before_kill + grace);
    return {static_cast<int>(Exit::interrupted), fmt::format("stopped by {}: {}.", ::strsignal(number), where), 0};
}

}  // namespace

RunEnding launch(Scene const& scene, std::filesystem::path const& directory, Progress& progress)
{
    asked_to_stop = 0;
    SignalGuard const guard;
    auto const begin = Clock::now();
    adopt_orphans();
    auto crew = start(scene, directory);
    RunEnding ending;
    for (;;) {
        crew.map_pages();
        if (asked_to_stop) {
            ending = interrupted(crew);
            break;
        }
        if (crew.one_failed()) {
            int const root = end_all(crew, crew.gone.value_or(Clock::now()));
            ending = explain(crew, root);
            break;
        }
        if (crew.all_ended()) break;
        progress.show(crew.pages);
        std::this_thread::sleep_for(tick);
    }
    crew.signal_all(SIGKILL);
    end_orphans();
    progress.clear();
    ending.wall_seconds = std::chrono::duration<double>(Clock::now() - begin).count();
    return ending;
}

}  // namespace sluice
