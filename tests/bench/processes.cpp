#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <stdexcept>

#include "coupler/base/scratch_directory.hpp"
#include "tests/bench/measure.hpp"
#include "tests/bench/raw.hpp"

namespace bench {
namespace {

//! A directory that only this user can enter, removed with everything in it.
class Directory : public sluice::ScratchDirectory
{
 public:
    Directory() : ScratchDirectory("sluice-bench")
    {
        for (auto const name : {"shm", "zmq"}) {
            std::filesystem::create_directory(path() / name);
            std::filesystem::permissions(path() / name, std::filesystem::perms::owner_all);
        }
    }
};

std::span<std::byte> shared_arena(std::size_t size)
{
    void* const data = ::mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS | MAP_POPULATE, -1, 0);
    if (data == MAP_FAILED) throw std::runtime_error("no shared memory");
    return {static_cast<std::byte*>(data), size};
}

[[noreturn]] void be_side_1(nlohmann::json (*body)(Setting const&, Effort const&), Setting const& setting,
                            Effort const& effort)
{
    try {
        (void)body(setting, effort);
        ::_exit(0);
    } catch (std::exception const& e) {
        std::fprintf(stderr, "side 1: %s\n", e.what());
    }
    ::_exit(1);
}

}  // namespace

nlohmann::json in_two_processes(nlohmann::json (*body)(Setting const&, Effort const&), Effort const& effort)
{
    Directory const directory;
    std::size_t const most = effort.sizes.back().points;
    auto const arena = shared_arena(raw_shm_size(most));
    int const port = 10'000 + ::getpid() % 700 * 32;
    Setting setting{0, directory.path(), port, arena, most};
    std::fflush(stdout);
    pid_t const child = ::fork();
    if (child < 0) throw std::runtime_error("fork failed");
    if (child == 0) {
        setting.side = 1;
        be_side_1(body, setting, effort);
    }
    auto results = body(setting, effort);
    int status = 0;
    ::waitpid(child, &status, 0);
    ::munmap(arena.data(), arena.size());
    if (status != 0) throw std::runtime_error("side 1 failed");
    return results;
}

nlohmann::json under_mpirun(bool small, bool windows)
{
    auto const program = std::filesystem::read_symlink("/proc/self/exe").string();
    Directory const directory;
    auto const file = (directory.path() / "results.json").string();
    ::setenv("OMPI_ALLOW_RUN_AS_ROOT", "1", 0);
    ::setenv("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1", 0);
    std::fflush(stdout);
    pid_t const child = ::fork();
    if (child < 0) throw std::runtime_error("fork failed");
    if (child == 0) {
        ::execlp("mpirun", "mpirun", "--oversubscribe", "--bind-to", "none", "-np", "2", program.c_str(), "--mpi-side",
                 file.c_str(), small ? "--small" : "--full", windows ? "--windows" : nullptr, nullptr);
        ::_exit(127);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    if (status != 0) throw std::runtime_error("mpirun failed");
    return nlohmann::json::parse(std::ifstream(file));
}

}  // namespace bench
