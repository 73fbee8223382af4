#include "coupler/command_line.hpp"

#include <sys/prctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <sstream>

#include "coupler/session.hpp"

namespace sluice {
namespace {

std::atomic<int> terminated{0};

//! SIGTERM: the run stops at the next window, with a checkpoint if it can; a second one ends the process.
extern "C" void note_signal(int number)
{
    terminated = 1;
    std::signal(number, SIG_DFL);
}

//! Which of its program's processes this is, when mpirun started it: Open MPI tells how many each program has.
int rank_under_mpirun()
{
    char const* const world = std::getenv("OMPI_COMM_WORLD_RANK");
    char const* const sizes = std::getenv("OMPI_APP_CTX_NUM_PROCS");
    if (!world) return 0;
    int rank = std::atoi(world);
    std::istringstream programs(sizes ? sizes : "");
    for (int size; programs >> size && rank >= size;) rank -= size;
    return rank;
}

}  // namespace

std::int32_t asked_by_signal()
{
    return terminated.load(std::memory_order_relaxed) != 0 && terminated.exchange(0) != 0
               ? static_cast<std::int32_t>(Request::stop)
               : 0;
}

int parse_command_line(int argc, char const* const* argv, JoinOptions& options)
{
    CLI::App app{"A participant of a coupled run. `sluice run SCENE` starts all of them; this starts one by hand."};
    app.add_option("SCENE", options.scene, "the scene (YAML)")->required();
    app.add_option("--as", options.name, "which participant of the scene this process is")->required();
    app.add_option("--out", options.directory, "directory of the run, the same for all participants (runs/SCENE)");
    app.add_option("--set", options.overrides, "path=value: change the scene, the same for all participants")
        ->allow_extra_args(false);
    app.add_option("--rank", options.rank,
                   "which of the participant's processes this is, from 0 (under mpirun: known)");
    app.add_flag("--resume", options.resume, "go on from the newest complete checkpoint of the run");
    app.add_flag("--check", options.check, "read and check the configuration, then stop");
    app.set_version_flag("--version", SLUICE_VERSION);
    try {
        app.parse(argc, argv);
    } catch (CLI::ParseError const& e) {
        return app.exit(e) == 0 ? 0 : static_cast<int>(Exit::config);
    }
    if (app.count("--rank") == 0) options.rank = rank_under_mpirun();
    if (options.directory.empty()) options.directory = std::filesystem::path("runs") / options.scene.stem();
    return -1;
}

void heed_signals()
{
    std::signal(SIGPIPE, SIG_IGN);
    std::signal(SIGTERM, note_signal);
    if (std::getenv(parent_death)) ::prctl(PR_SET_PDEATHSIG, SIGKILL);
}

void write_log_by_lines()
{
    std::setvbuf(stdout, nullptr, _IOLBF, BUFSIZ);
}

void require_log()
{
    if (std::ferror(stdout) == 0) [[likely]]
        return;
    struct stat info = {};
    if (::fstat(STDOUT_FILENO, &info) != 0 || !S_ISREG(info.st_mode)) return;  // a pipe that nobody reads any more
    int const error = ::write(STDOUT_FILENO, "\n", 1) == 1 ? 0 : errno;
    throw Error(std::string("standard output, the log: lines were lost: ") +
                    (error ? std::strerror(error) : "there was no room for a while") + ". Make room, then resume.",
                Exit::io);
}

int exit_for_launcher(int exit)
{
    bool const stopped = exit == static_cast<int>(Exit::stopped) || exit == static_cast<int>(Exit::interrupted);
    return stopped && std::getenv(parent_death) && std::getenv("OMPI_COMM_WORLD_SIZE") ? 0 : exit;
}

}  // namespace sluice
