#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "coupler/cli/crew.hpp"

namespace sluice {

//! Whether a run begins anew or goes on from its newest checkpoint.
enum class Begin
{
    anew,
    resumed
};

//! What is to be started for a scene, nothing of it running yet. Throws Error (exit 7) if mpirun is needed and missing.
std::vector<Job> jobs_of(Scene const& scene, std::vector<CrewMember> const& members,
                         std::filesystem::path const& directory, Begin begin);

//! Whether `host` is this machine: empty, loopback, its name, or an address of one of its interfaces.
bool is_this_machine(std::string const& host);

//! The command that starts a participant on another host, without `--as` and what follows.
std::vector<std::string> program_there(ParticipantSpec const& spec);

//! What starts `program` on another host: the scene's `remote` words, the host, the program. Throws Error (exit 2) if
//! the scene has no such words.
std::vector<std::string> remotely(Scene const& scene, std::string const& host, std::vector<std::string> const& program);

//! `words` in such a way that a program which joins its arguments for a shell (ssh, rsh) starts exactly that.
std::vector<std::string> quoted_for_shell(std::vector<std::string> const& words);

//! Removes what an earlier run left under the names of this one's results, so that old and new never stand side by
//! side.
void remove_old_results(Scene const& scene, std::filesystem::path const& directory);

//! Before a resumed run: results and logs stay, what the processes said about themselves is put aside.
void put_part_aside(Scene const& scene, std::filesystem::path const& directory, int part);

//! Where the summary of a member's earlier part of the run is.
std::filesystem::path part_summary(std::filesystem::path const& directory, std::string const& member, int part);

}  // namespace sluice
