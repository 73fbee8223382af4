#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "coupler/cli/check.hpp"

namespace sluice {

//! What the command line said; each command looks at its own part.
struct Options
{
    SceneChoice choice;
    std::filesystem::path directory;  //!< of a run's results, or of a new scene
    bool quiet = false;
    bool json = false;  //!< the answer as JSON on standard output, and nothing else there
    bool report = true;
    std::filesystem::path picture;            //!< graph -o
    std::vector<std::filesystem::path> runs;  //!< report, watch
    std::filesystem::path page;               //!< report -o, schema -o
    std::string word;                         //!< init: the template; explain: what
    std::vector<std::string> names;           //!< keygen: participants, or a scene; replay: who is run
    bool once = false;                        //!< watch
    std::filesystem::path paths_in;           //!< schema --paths: the scene
};

//! The commands: each returns the exit code, or throws Error. Those that print JSON print one value and a line end.
int run_command(Options options);
int resume_command(Options options);
int check_command(Options const& options);
int graph_command(Options const& options);
int schema_command(Options const& options);
int report_command(Options options);
int record_command(Options const& options);
int replay_command(Options options);
int explain_command(Options const& options);
int init_command(Options options);
int doctor_command(Options const& options);
int watch_command(Options const& options);

}  // namespace sluice
