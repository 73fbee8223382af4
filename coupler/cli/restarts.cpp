#include "coupler/cli/restarts.hpp"

#include <fmt/format.h>
#include <signal.h>
#include <sys/wait.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <new>

#include "coupler/base/error.hpp"
#include "coupler/cli/post_mortem.hpp"
#include "coupler/cli/start.hpp"
#include "coupler/record/checkpoint.hpp"

namespace sluice {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds grace{700};  // for a process that says it failed to end

//! What another start would not change: scene, time-out, versions, safety, a program that is not there.
bool is_hopeless(int exit)
{
    constexpr std::array hopeless{static_cast<int>(Exit::config),
                                  static_cast<int>(Exit::timeout),
                                  static_cast<int>(Exit::protocol),
                                  static_cast<int>(Exit::security),
                                  126,
                                  127};
    return std::find(hopeless.begin(), hopeless.end(), exit) != hopeless.end();
}

}  // namespace

bool Restarts::refuse(std::string const& why)
{
    why_not_ = "not started again: " + why;
    return false;
}

//! The process and all that it had started: their names are free then.
bool Restarts::has_ended(Crew& crew, Job& job)
{
    if (!seen_) seen_ = Clock::now();
    bool ended = job.process->poll().has_value();
    if (ended && job.mpirun) job.process->signal(SIGKILL);
    for (auto const m : job.members) {
        if (job.remote || !job.mpirun || !crew.pages[m] || crew.pages[m]->pid <= 0) continue;
        int const pid = crew.pages[m]->pid;
        ::waitpid(pid, nullptr, WNOHANG);  // it is ours once mpirun has ended
        ended = ended && ::kill(pid, 0) != 0;
    }
    if (!ended && Clock::now() - *seen_ > grace) job.process->signal(SIGKILL);
    return ended;
}

bool Restarts::may_restart(Crew& crew, Job& job)
{
    for (std::size_t m = 0; m < crew.members.size(); ++m)
        if (crew.is_done(m)) return refuse("\"" + crew.members[m].name + "\" has already come to the end of the run.");
    for (auto const m : job.members)
        if (crew.has_failed(m) && (crew.pages[m]->consequence || is_hopeless(crew.pages[m]->exit)))
            return refuse("another start would end like this one.");
    if (auto const ending = job.process->poll(); ending && !job.mpirun && is_hopeless(ending->code))
        return refuse("another start would end like this one.");
    auto const found = CheckpointStore(crew.directory, crew.scene.checkpoint.keep).newest();
    if (!found.manifest) return refuse("there is no complete checkpoint yet.");
    if (found.manifest->window > checkpoint_) without_progress_ = 0;
    checkpoint_ = found.manifest->window;
    if (++without_progress_ > in_a_row)
        return refuse(
            fmt::format("that was tried {} times without coming to a new checkpoint (the last is that of "
                        "window {}).",
                        in_a_row, checkpoint_));
    return true;
}

void Restarts::restart(Crew& crew, Job& job, std::size_t number)
{
    auto const verdict = explain(crew, root_cause(crew));
    std::fprintf(stderr, "%s\n  started again, all go on from window %lld (restart %d)\n",
                 verdict.message.substr(0, verdict.message.find('\n')).c_str(), static_cast<long long>(checkpoint_),
                 total_ + 1);
    for (auto const m : job.members)
        if (crew.pages[m]) new (crew.pages[m].operator->()) StatusPage;
    job.argv = std::move(jobs_of(crew.scene, crew.members, crew.directory, Begin::resumed)[number].argv);
    crew.started = Clock::now();
    crew.start(job, Log::append);
    seen_.reset();
    ++total_;
}

bool Restarts::deal_with(Crew& crew)
{
    if (!crew.scene.restart_on_death) return false;
    for (std::size_t j = 0; j < crew.jobs.size(); ++j) {
        auto& job = crew.jobs[j];
        if (crew.state_of(job) != Crew::State::failed) continue;
        if (!has_ended(crew, job)) return true;
        if (!may_restart(crew, job)) return false;
        restart(crew, job, j);
    }
    return true;
}

}  // namespace sluice
