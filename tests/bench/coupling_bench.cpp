//! What coupling costs beside what the medium allows: round trips of two processes on this host. Prints a table;
//! `--json FILE` writes a list of {case, metric, value, unit, against, ratio, min, max}. `--small`: a smoke run.
//! `--runs`: only what concerns whole runs.
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>

#include "tests/bench/measure.hpp"
#include "tests/bench/raw.hpp"
#include "tests/bench/runs.hpp"
#include "tests/bench/session_way.hpp"
#include "tests/bench/transport_way.hpp"

namespace {

using bench::Contestant;
using bench::Effort;
using bench::Setting;

std::vector<Contestant> const by_fork = {
    {"raw shared memory", "raw shared memory", bench::raw_shm}, {"shm", "raw shared memory", bench::our_shm},
    {"raw ZeroMQ ipc", "raw ZeroMQ ipc", bench::raw_zmq_ipc},   {"zmq ipc", "raw ZeroMQ ipc", bench::our_zmq_ipc},
    {"raw ZeroMQ tcp", "raw ZeroMQ tcp", bench::raw_zmq_tcp},   {"zmq tcp", "raw ZeroMQ tcp", bench::our_zmq_tcp},
};
// whole windows of a coupled run
std::vector<Contestant> const windows = {
    {"raw shared memory", "raw shared memory", bench::raw_shm},
    {"window, shm, serial", "raw shared memory", bench::session_shm},
    {"window, shm, parallel", "raw shared memory", bench::session_shm_parallel},
    {"window, shm, lattice both ways", "raw shared memory", bench::session_lattice},
    {"window, loads, no ledger", "raw shared memory", bench::session_unbooked},
    {"window, loads, amounts", "raw shared memory", bench::session_amounts},
    {"window, loads, energy in each", "raw shared memory", bench::session_energy},
    {"raw ZeroMQ ipc", "raw ZeroMQ ipc", bench::raw_zmq_ipc},
    {"window, zmq ipc, serial", "raw ZeroMQ ipc", bench::session_zmq},
    {"window, zmq ipc, parallel", "raw ZeroMQ ipc", bench::session_zmq_parallel},
};
std::vector<Contestant> const windows_by_mpirun = {
    {"window, mpi, serial", "raw MPI", bench::session_mpi},  // first: it starts MPI
    {"raw MPI", "raw MPI", bench::raw_mpi},
};
std::vector<Contestant> const by_mpirun = {
    {"mpi", "raw MPI", bench::our_mpi},  // first: it starts MPI
    {"raw MPI", "raw MPI", bench::raw_mpi},
};

void show(nlohmann::json const& results)
{
    for (auto const& r : results) {
        std::printf("%-33s %-42s %10.4g %-3s", r.at("case").get<std::string>().c_str(),
                    r.at("metric").get<std::string>().c_str(), r.at("value").get<double>(),
                    r.at("unit").get<std::string>().c_str());
        if (r.contains("min")) std::printf(" (%.4g to %.4g)", r.at("min").get<double>(), r.at("max").get<double>());
        std::printf("  %.2f x %s\n", r.at("ratio").get<double>(), r.at("against").get<std::string>().c_str());
    }
    std::fflush(stdout);
}

nlohmann::json all_round_trips(Setting const& setting, Effort const& effort)
{
    return bench::round_trips(by_fork, bench::make_ways(by_fork, setting), setting.side, effort);
}

nlohmann::json all_windows(Setting const& setting, Effort const& effort)
{
    return bench::round_trips(windows, bench::make_ways(windows, setting), setting.side, effort);
}

//! Alone: another transport's threads would be counted.
template <std::size_t Which>
nlohmann::json idle(Setting const& setting, Effort const& effort)
{
    auto const way = by_fork[Which].make(setting);
    return bench::idle_wait(by_fork[Which], *way, effort);
}

//! One of the two processes under mpirun.
int mpi_side(char const* file, Effort const& effort, bool sessions)
{
    auto const& contestants = sessions ? windows_by_mpirun : by_mpirun;
    char const* const rank = std::getenv("OMPI_COMM_WORLD_RANK");
    Setting const setting{.side = rank ? std::atoi(rank) : 0,
                          .directory = std::filesystem::path(file).parent_path(),
                          .most_points = effort.sizes.back().points};
    try {
        auto const ways = bench::make_ways(contestants, setting);
        auto results = bench::round_trips(contestants, ways, setting.side, effort);
        if (!sessions) {
            auto const idle = bench::idle_wait(by_mpirun[0], *ways[0], effort);
            results.insert(results.end(), idle.begin(), idle.end());
        }
        if (setting.side == 0) std::ofstream(file) << results;
        return 0;
    } catch (std::exception const& e) {
        std::fprintf(stderr, "side %d: %s\n", setting.side, e.what());
        std::_Exit(1);  // mpirun ends the other one
    }
}

}  // namespace

int main(int argc, char** argv)
{
    bool small = false, sessions = false, only_runs = false;
    char const* json = nullptr;
    char const* mpi_file = nullptr;
    for (int i = 1; i < argc; ++i) {
        if (std::strcmp(argv[i], "--small") == 0) small = true;
        if (std::strcmp(argv[i], "--json") == 0 && i + 1 < argc) json = argv[++i];
        if (std::strcmp(argv[i], "--windows") == 0) sessions = true;
        if (std::strcmp(argv[i], "--runs") == 0) only_runs = true;
        if (std::strcmp(argv[i], "--mpi-side") == 0 && i + 1 < argc) mpi_file = argv[++i];
    }
    auto const effort = small ? Effort::small() : Effort::full();
    if (mpi_file) return mpi_side(mpi_file, effort, sessions);
    try {
        auto results = nlohmann::json::array();
        auto const add = [&](nlohmann::json const& more) {
            show(more);
            results.insert(results.end(), more.begin(), more.end());
        };
        auto const runs = small ? bench::RunEffort::small() : bench::RunEffort();
        add(bench::start_up(runs));
        add(bench::waiting(runs));
        add(bench::bytes_sent());
        add(bench::overlap(runs));
        if (!only_runs) {
            add(bench::in_two_processes(all_round_trips, effort));
            add(bench::under_mpirun(small, false));
            add(bench::in_two_processes(all_windows, effort));
            add(bench::under_mpirun(small, true));
            add(bench::in_two_processes(idle<1>, effort));
            add(bench::in_two_processes(idle<3>, effort));
        }
        if (json) std::ofstream(json) << results.dump(1) << '\n';
        return 0;
    } catch (std::exception const& e) {
        std::fprintf(stderr, "coupling_bench: %s\n", e.what());
        return 1;
    }
}
