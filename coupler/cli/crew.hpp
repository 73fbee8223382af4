#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "coupler/base/scratch_directory.hpp"
#include "coupler/base/status_page.hpp"
#include "coupler/cli/process.hpp"
#include "coupler/scene/scene.hpp"

namespace sluice {

//! One process of a participant.
struct CrewMember
{
    int participant = 0;
    int rank = 0;
    std::string name;  //!< "grains", or "water:1" where a participant has several processes
};
std::vector<CrewMember> members_of_crew(Scene const& scene);

using Variables = std::vector<std::pair<std::string, std::string>>;
//! What mpirun needs beside its arguments: it gives up the processor, and ends what it started at once.
Variables mpirun_environment();

//! What is started at once: a participant, or one mpirun with the processes of a participant or of all.
struct Job
{
    std::vector<std::string> argv;
    std::filesystem::path log;
    std::vector<std::size_t> members;  //!< indices into Crew::members
    bool mpirun = false;
    bool remote = false;                             //!< its process runs on another host: pids mean nothing here
    std::unique_ptr<ScratchDirectory> scratch = {};  //!< mpirun's own
    std::unique_ptr<Process> process = {};
    std::optional<std::chrono::steady_clock::time_point> gone = {};  //!< mpirun: when a process was first found gone
    std::optional<std::size_t> who = {};                             //!< which member that was
};

//! The processes of a run and their status pages.
struct Crew
{
    enum class State
    {
        running,
        done,   //!< every member said that it was done, and the process ended accordingly
        failed  //!< it ended otherwise, or a member says that it failed
    };

    Scene const& scene;
    std::filesystem::path directory;
    std::vector<CrewMember> members;
    std::vector<MappedStatus> pages;  //!< per member; empty until it has made its own
    std::vector<Job> jobs;
    std::chrono::steady_clock::time_point started = std::chrono::steady_clock::now();

    void start(Job& job, Log log);
    void map_pages();
    bool is_done(std::size_t member) const { return pages[member] && pages[member]->phase == Phase::done; }
    bool has_failed(std::size_t member) const { return pages[member] && pages[member]->phase == Phase::failed; }
    State state_of(Job& job);
    bool all_ended();
    bool all_done() const;
    void ask_all_to_end() const;  //!< SIGTERM
    void kill_all() const;
    StatusPage* pacer_page() const;  //!< of the process that takes requests; null: it has none yet

 private:
    void look_for_the_gone(Job& job);
};

}  // namespace sluice
