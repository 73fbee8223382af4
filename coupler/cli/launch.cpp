#include "coupler/cli/launch.hpp"

#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstring>
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
constexpr milliseconds grace{700};         // for the others to say why they stop, after the first has ended
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

    bool all_ended()
    {
        bool all = true;
        for (auto& process : processes) all = process.poll().has_value() && all;
        return all;
    }
    bool one_failed()
    {
        for (auto& process : processes)
            if (auto const ending = process.poll(); ending && !ending->well()) return true;
        for (auto const& page : pages)
            if (page && page->phase == Phase::failed) return true;
        return false;
    }
    void signal_all(int number)
    {
        for (auto& process : processes)
            if (!process.poll()) process.signal(number);
    }
    //! mpirun's own children outlive a killed mpirun: they are ended by the process ids that they wrote down.
    void kill_what_mpirun_left()
    {
        for (auto const& page : pages) {
            if (!mpi || !page || page->pid <= 0 || page->phase == Phase::done) continue;
            ::kill(page->pid, SIGKILL);
            for (int tries = 0; tries < 50 && ::kill(page->pid, 0) == 0; ++tries)
                std::this_thread::sleep_for(milliseconds(5));
        }
    }
    void map_pages()
    {
        for (std::size_t p = 0; p < pages.size(); ++p)
            if (!pages[p]) {
                auto const file = status_file(directory, scene.participants[p].name);
                std::error_code none;
                if (std::filesystem::file_size(file, none) != sizeof(StatusPage) || none) continue;
                pages[p] = MappedStatus(file, MappedStatus::Mode::open);
            }
    }
};

Crew start(Scene const& scene, std::filesystem::path const& directory)
{
    Crew crew{scene, directory, {}, {}, {}, scene.transport == TransportKind::mpi && scene.participants.size() > 1};
    for (auto const& spec : scene.participants) {
        std::filesystem::remove(status_file(directory, spec.name));
        std::filesystem::remove(directory / ".sluice" / (spec.name + ".json"));
        crew.pages.emplace_back(status_file(directory, spec.name), MappedStatus::Mode::open);
    }
    if (crew.mpi) {
        require(!find_executable("mpirun").empty(), [] {
            return Error("transport: mpi needs mpirun, which is not on PATH. Install the package openmpi-bin.",
                         Exit::io);
        });
        crew.logs.push_back((directory / "mpirun.log").string());
        crew.processes.emplace_back(
            mpi_command(scene, directory), crew.logs.back(),
            std::vector<std::pair<std::string, std::string>>{{"OMPI_MCA_mpi_yield_when_idle", "1"}});
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
    if (std::regex_search(text, m, std::regex("Exit code: *(\\d+)"))) return {std::stoi(m[1]), 0};
    return {1, 0};
}

//! Which participant failed by itself, not because another one did; -1: none said so.
int root_cause(Crew& crew)
{
    for (std::size_t p = 0; p < crew.pages.size(); ++p)
        if (crew.pages[p] && crew.pages[p]->phase == Phase::failed && !crew.pages[p]->consequence)
            return static_cast<int>(p);
    for (std::size_t p = 0; p < crew.pages.size(); ++p) {
        bool const ended =
            crew.mpi ? crew.pages[p] && ::kill(crew.pages[p]->pid, 0) != 0 : crew.processes[p].poll().has_value();
        bool const done =
            crew.pages[p] && (crew.pages[p]->phase == Phase::done || crew.pages[p]->phase == Phase::failed);
        if (ended && !done) return static_cast<int>(p);
    }
    return -1;
}

RunEnding explain(Crew& crew, int root)
{
    RunEnding ending;
    ending.exit = static_cast<int>(Exit::peer_died);
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
        if (root < 0) root = root_cause(crew);
        auto const since = Clock::now() - first_failure;
        if (!asked && since > grace) {
            asked = true;
            crew.signal_all(SIGTERM);
        }
        if (!killed && since > before_kill) {
            killed = true;
            crew.signal_all(SIGKILL);
        }
        std::this_thread::sleep_for(tick);
    }
    crew.kill_what_mpirun_left();
    return root < 0 ? root_cause(crew) : root;
}

RunEnding interrupted(Crew& crew)
{
    int const number = asked_to_stop;
    std::string where;
    for (std::size_t p = 0; p < crew.pages.size(); ++p)
        where += (p ? ", \"" : "\"") + crew.scene.participants[p].name + "\" " + place(crew.pages[p]);
    crew.signal_all(SIGTERM);
    end_all(crew, Clock::now() - grace);
    return {static_cast<int>(Exit::interrupted), fmt::format("stopped by {}: {}.", ::strsignal(number), where), 0};
}

}  // namespace

RunEnding launch(Scene const& scene, std::filesystem::path const& directory, Progress& progress)
{
    asked_to_stop = 0;
    SignalGuard const guard;
    auto const begin = Clock::now();
    auto crew = start(scene, directory);
    RunEnding ending;
    for (;;) {
        crew.map_pages();
        if (asked_to_stop) {
            ending = interrupted(crew);
            break;
        }
        if (crew.one_failed()) {
            int const root = end_all(crew, Clock::now());
            ending = explain(crew, root);
            break;
        }
        if (crew.all_ended()) break;
        progress.show(crew.pages);
        std::this_thread::sleep_for(tick);
    }
    progress.clear();
    ending.wall_seconds = std::chrono::duration<double>(Clock::now() - begin).count();
    return ending;
}

}  // namespace sluice
