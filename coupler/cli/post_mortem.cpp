#include "coupler/cli/post_mortem.hpp"

#include <fmt/format.h>

#include <cstring>
#include <regex>
#include <sstream>

#include "coupler/base/error.hpp"
#include "coupler/record/atomic_file.hpp"

namespace sluice {
namespace {

constexpr std::size_t log_lines = 20;

std::string words_of(std::optional<Ending> const& ending)
{
    if (!ending) return "ended; mpirun does not say how";
    if (ending->signal != 0)
        return fmt::format("was ended by signal {} ({})", ending->signal, ::strsignal(ending->signal));
    return fmt::format("ended with exit code {}", ending->code);
}

//! ssh and its like know no signals: whatever is not an exit code of the program comes as 255.
std::string note_on(Job const& job, std::optional<Ending> const& ending)
{
    if (!job.remote || !ending || ending->code != 255) return {};
    return " (the connection broke, or a signal ended it there)";
}

//! How mpirun says that the first of its processes ended.
std::optional<Ending> ending_in(std::filesystem::path const& mpirun_log)
{
    auto const text = read_file(mpirun_log);
    std::smatch m;
    if (std::regex_search(text, m, std::regex("exited on signal (\\d+)"))) return Ending{0, std::stoi(m[1])};
    if (std::regex_search(text, m, std::regex("Signal: [^\n]*\\((\\d+)\\)"))) return Ending{0, std::stoi(m[1])};
    if (std::regex_search(text, m, std::regex("Exit code: *(\\d+)"))) return Ending{std::stoi(m[1]), 0};
    return std::nullopt;
}

Job& job_of(Crew& crew, std::size_t member)
{
    for (auto& job : crew.jobs)
        for (auto const m : job.members)
            if (m == member) return job;
    throw Error("a member that nobody started.", Exit::internal);
}

//! ", process 1234"; empty when it is not known.
std::string process_of(Crew const& crew, Job const& job, std::size_t member)
{
    auto const& page = crew.pages[member];
    bool const own = !job.mpirun && !job.remote;
    auto const number = page && page->pid > 0 ? page->pid.load() : own ? job.process->pid() : 0;
    if (number <= 0) return {};
    return fmt::format(", process {}", number);
}

//! What the log ends with, apart from what the message says already; with a heading.
std::string end_of_log(Job const& job, std::string const& message)
{
    std::string lines;
    std::istringstream all(last_lines(job.log, log_lines));
    for (std::string line; std::getline(all, line);)
        if (auto const begin = line.find_first_not_of(' ');
            begin != line.npos && message.find(line.substr(begin)) == message.npos)
            lines += "\n" + line;
    return lines.empty() ? lines : "\n  its log, " + job.log.string() + ", ends with:" + lines;
}

//! The others that stopped because of the root cause, in one line.
std::string consequences(Crew const& crew, std::size_t root)
{
    std::string names;
    for (std::size_t m = 0; m < crew.members.size(); ++m)
        if (m != root && crew.has_failed(m) && crew.pages[m]->consequence)
            names += (names.empty() ? "\"" : ", \"") + crew.members[m].name + "\" " + place_of(crew.pages[m]);
    return names.empty() ? "" : "\n  stopped because of it: " + names;
}

}  // namespace

std::string place_of(MappedStatus const& page)
{
    if (!page || page->phase == Phase::absent || page->windows == 0) return "before its first window";
    return fmt::format("in window {} of {} (t = {:.6g} s)", page->window.load(), page->windows.load(),
                       page->time.load());
}

std::string places_of(Crew const& crew)
{
    std::string text;
    for (std::size_t m = 0; m < crew.members.size(); ++m)
        text += (m ? ", \"" : "\"") + crew.members[m].name + "\" " + place_of(crew.pages[m]);
    return text;
}

std::optional<Ending> ending_of(Job& job)
{
    return job.mpirun ? ending_in(job.log) : job.process->wait();
}

std::optional<std::size_t> root_cause(Crew& crew)
{
    for (std::size_t m = 0; m < crew.members.size(); ++m)
        if (crew.has_failed(m) && !crew.pages[m]->consequence) return m;
    for (auto& job : crew.jobs) {
        if (crew.state_of(job) != Crew::State::failed) continue;
        if (job.mpirun && job.who) return job.who;
        for (auto const m : job.members)
            if (!crew.is_done(m) && !crew.has_failed(m)) return m;
        if (!job.mpirun && !crew.has_failed(job.members[0])) return job.members[0];  // done, and then it crashed
    }
    return std::nullopt;
}

Verdict explain(Crew& crew, std::optional<std::size_t> root)
{
    Verdict verdict{static_cast<int>(Exit::peer_died), {}};
    for (std::size_t m = 0; m < crew.members.size() && !root; ++m)  // only consequences: the first tells most
        if (crew.has_failed(m)) root = m;
    if (!root) {
        verdict.message = "the run ended early. Look at the logs in " + crew.directory.string() + ".";
        return verdict;
    }
    auto const& name = crew.members[*root].name;
    auto const& page = crew.pages[*root];
    auto& job = job_of(crew, *root);
    auto const& host = crew.scene.participants[static_cast<std::size_t>(crew.members[*root].participant)].host;
    auto const who = fmt::format("participant \"{}\"{}", name, job.remote ? " on " + host : "");
    if (page && page->phase == Phase::failed) {
        verdict.exit = page->exit;
        verdict.message =
            fmt::format("{} stopped {}{}: {}", who, place_of(page), process_of(crew, job, *root), page->message);
        auto const log = job.mpirun ? std::string() : end_of_log(job, verdict.message);
        verdict.message += consequences(crew, *root) + log;
    } else {
        auto const ending = ending_of(job);
        auto const process = process_of(crew, job, *root);
        verdict.message =
            fmt::format("{} {}{} {}{}.", who, words_of(ending), note_on(job, ending), place_of(page), process);
        auto const log = end_of_log(job, verdict.message);
        verdict.message += consequences(crew, *root) +
                           (log.empty() ? "\n  its log, " + job.log.string() + ", ends with: nothing" : log);
    }
    return verdict;
}

}  // namespace sluice
