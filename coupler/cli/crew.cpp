#include "coupler/cli/crew.hpp"

#include <signal.h>

#include <algorithm>
#include <cerrno>

namespace sluice {

using Clock = std::chrono::steady_clock;

namespace {

constexpr std::chrono::milliseconds mpirun_time{1600};  // it notices a dead process in 0.4 s on an idle machine

}  // namespace

std::vector<CrewMember> members_of_crew(Scene const& scene)
{
    std::vector<CrewMember> members;
    for (std::size_t p = 0; p < scene.participants.size(); ++p) {
        auto const& spec = scene.participants[p];
        for (int rank = 0; rank < spec.ranks; ++rank)
            members.push_back(
                {static_cast<int>(p), rank, spec.ranks == 1 ? spec.name : spec.name + ":" + std::to_string(rank)});
    }
    return members;
}

Variables mpirun_environment()
{
    return {{"OMPI_MCA_mpi_yield_when_idle", "1"},
            {"OMPI_MCA_odls_base_sigkill_timeout", "0"},  // else it sleeps 1 s over its dead
            {parent_death, "1"}};
}

void Crew::start(Job& job, Log log)
{
    job.gone.reset();
    job.who.reset();
    Variables environment;
    if (job.mpirun) {  // two that begin, or end, at once would get in each other's way in one directory
        job.scratch = std::make_unique<ScratchDirectory>("sluice-mpirun");
        environment = mpirun_environment();
        environment.emplace_back("OMPI_MCA_orte_tmpdir_base", job.scratch->path().string());
    }
    job.process = std::make_unique<Process>(job.argv, job.log, environment, log);
}

void Crew::map_pages()
{
    for (std::size_t m = 0; m < pages.size(); ++m)
        if (!pages[m]) pages[m] = MappedStatus(status_file(directory, members[m].name), MappedStatus::Mode::open);
}

//! mpirun: a process is gone though it was not done, or never came. mpirun ends the others and says how it ended; only
//! if it does not within its time is it our turn.
void Crew::look_for_the_gone(Job& job)
{
    bool const late = Clock::now() - started > std::chrono::duration<double>(scene.connect_timeout);
    for (auto const m : job.members) {
        if (job.gone && job.who != m) continue;
        bool const there = pages[m] && pages[m]->pid > 0;
        bool const dead = there && !is_done(m) && !job.remote && ::kill(pages[m]->pid, 0) != 0 && errno == ESRCH;
        bool const missing = dead || (!there && late);
        if (!missing && job.gone) {  // it has come after all
            job.gone.reset();
            job.who.reset();
        }
        if (!missing || job.gone) continue;
        job.gone = Clock::now();
        job.who = m;
    }
}

Crew::State Crew::state_of(Job& job)
{
    auto const ending = job.process->poll();
    if (job.mpirun) look_for_the_gone(job);
    if (std::any_of(job.members.begin(), job.members.end(), [&](auto m) { return has_failed(m); }))
        return State::failed;
    bool const done = std::all_of(job.members.begin(), job.members.end(), [&](auto m) { return is_done(m); });
    if (!ending) return job.gone && Clock::now() - *job.gone > mpirun_time ? State::failed : State::running;
    if (job.mpirun) return done ? State::done : State::failed;
    bool const as_said = ending->signal == 0 && done && ending->code == pages[job.members[0]]->exit;
    return as_said ? State::done : State::failed;
}

bool Crew::all_ended()
{
    bool all = true;
    for (auto& job : jobs) all = job.process->poll().has_value() && all;
    return all;
}

bool Crew::all_done() const
{
    for (std::size_t m = 0; m < members.size(); ++m)
        if (!is_done(m)) return false;
    return true;
}

//! What reaches another host ends what it started there itself; srun does not if its own child gets the signal, too.
void Crew::ask_all_to_end() const
{
    for (auto const& job : jobs)
        if (job.remote)
            job.process->signal_itself(SIGTERM);
        else
            job.process->signal(SIGTERM);
}

void Crew::kill_all() const
{
    for (auto const& job : jobs) job.process->signal(SIGKILL);
}

StatusPage* Crew::pacer_page() const
{
    for (std::size_t m = 0; m < members.size(); ++m)
        if (members[m].participant == scene.pace && members[m].rank == 0)
            return pages[m] ? pages[m].operator->() : nullptr;
    return nullptr;
}

}  // namespace sluice
