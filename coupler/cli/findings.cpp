#include "coupler/cli/findings.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <hdf5.h>
#include <sched.h>
#include <sys/resource.h>
#include <sys/statvfs.h>
#include <unistd.h>
#include <zmq.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <thread>

#include "coupler/base/error.hpp"
#include "coupler/cli/process.hpp"
#include "coupler/record/atomic_file.hpp"

namespace sluice {
namespace {

using State = Finding::State;

constexpr double mega = 1024.0 * 1024.0;

//! What a command prints, and how it ended; nothing if it cannot be started or takes longer than 20 s.
struct Answer
{
    bool well = false;
    std::string text;
};

Answer ask(std::vector<std::string> const& argv)
{
    char name[] = "/tmp/sluice-doctor-XXXXXX";
    int const file = ::mkstemp(name);
    if (file < 0) return {};
    ::close(file);
    Answer answer;
    try {
        Process process(argv, name);
        auto const deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
        while (!process.poll() && std::chrono::steady_clock::now() < deadline)
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
        auto const ending = process.poll();
        answer.well = ending && ending->well();
        answer.text = read_file(name);
    } catch (Error const&) {  // not to be started: not well
    }
    ::unlink(name);
    return answer;
}

std::string first_line(std::string const& text)
{
    return text.substr(0, text.find('\n'));
}

Finding libraries()
{
    int major = 0, minor = 0, patch = 0;
    unsigned h5[3] = {};
    zmq_version(&major, &minor, &patch);
    H5get_libversion(&h5[0], &h5[1], &h5[2]);
    Finding f{"libraries", State::ok,
              fmt::format("ZeroMQ {}.{}.{}, HDF5 {}.{}.{}", major, minor, patch, h5[0], h5[1], h5[2]), ""};
    if (zmq_has("curve") != 1) {
        f.state = State::warn;
        f.found += ", ZeroMQ without CURVE";
        f.advice = "Connections between hosts cannot be encrypted: use a libzmq with libsodium.";
    }
    return f;
}

Finding solvers()
{
    Finding f{"solvers", State::ok, "", ""};
    for (char const* name : {"dem", "lbm", "mpm", "liggghts"}) {
        auto const found = find_executable(name);
        if (!found.empty()) f.found += (f.found.empty() ? "" : ", ") + found.lexically_normal().string();
    }
    if (f.found.empty())
        f = {"solvers", State::warn, "none of dem, lbm, mpm, liggghts beside sluice or on PATH",
             "Build them, or bring solvers of your own."};
    return f;
}

Finding mpi()
{
    auto const version = ask({"mpirun", "--version"});
    if (!version.well)
        return {"mpi", State::warn, "no mpirun", "Only for transport: mpi and ranks > 1: install openmpi-bin."};
    std::vector<std::string> argv{"mpirun", "--oversubscribe", "-np", "2", "true"};
    if (::geteuid() == 0) argv.insert(argv.begin() + 1, "--allow-run-as-root");
    auto const run = ask(argv);
    auto const found = first_line(version.text) + (::geteuid() == 0 ? ", as root" : "");
    if (run.well) return {"mpi", State::ok, found + ", starts 2 processes", ""};
    return {"mpi", State::warn, found + ": cannot start 2 processes: " + first_line(run.text),
            "transport: mpi will not work: try mpirun -np 2 true by hand."};
}

Finding shared_memory()
{
    struct statvfs s = {};
    std::filesystem::path const file = "/dev/shm/sluice-doctor-" + std::to_string(::getpid());
    int const descriptor = ::open(file.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
    if (descriptor < 0 || ::statvfs("/dev/shm", &s) != 0)
        return {"shared memory", State::fail, "/dev/shm cannot be written",
                "Mount a tmpfs there, or use transport: zmq."};
    ::close(descriptor);
    ::unlink(file.c_str());
    double const free = static_cast<double>(s.f_bavail) * static_cast<double>(s.f_frsize) / mega;
    Finding f{"shared memory", State::ok, fmt::format("/dev/shm, {:.0f} MB free", free), ""};
    if (free < 64) {
        f.state = State::warn;
        f.advice = "A coupling takes some frames' size there. In a container: --shm-size 1g.";
    }
    return f;
}

Finding limit(char const* what, int resource, double unit, char const* unit_name, double enough, char const* advice)
{
    struct rlimit r = {};
    ::getrlimit(static_cast<__rlimit_resource>(resource), &r);
    if (r.rlim_cur == RLIM_INFINITY) return {what, State::ok, "no limit", ""};
    double const value = static_cast<double>(r.rlim_cur) / unit;
    return {what, value >= enough ? State::ok : State::warn, fmt::format("{:.0f} {}", value, unit_name),
            value >= enough ? "" : advice};
}

//! The packages that report.html is made with.
Finding python()
{
    auto const answer = ask({"/usr/bin/python3", "-c",
                             "import importlib, platform\nout = ['Python ' + platform.python_version()]\n"
                             "for name in 'numpy', 'h5py', 'matplotlib':\n"
                             "    try: out.append(name + ' ' + importlib.import_module(name).__version__)\n"
                             "    except Exception: out.append('no ' + name)\n"
                             "print(', '.join(out))"});
    if (!answer.well) return {"python", State::warn, "no /usr/bin/python3", "No report.html: install python3."};
    bool const lacks = answer.text.find("no ") != answer.text.npos;
    return {"python", lacks ? State::warn : State::ok, first_line(answer.text),
            lacks ? "No report.html: install python3-numpy python3-h5py python3-matplotlib." : ""};
}

Finding graphviz()
{
    auto const answer = ask({"dot", "-V"});
    if (!answer.well) return {"graphviz", State::warn, "no dot", "sluice graph -o needs it: install graphviz."};
    return {"graphviz", State::ok, first_line(answer.text), ""};
}

Finding clock_source()
{
    std::string source = "unknown";
    std::ifstream("/sys/devices/system/clocksource/clocksource0/current_clocksource") >> source;
    constexpr int reads = 1000;
    using Clock = std::chrono::steady_clock;
    auto const begin = Clock::now();
    for (int i = 1; i < reads; ++i) static_cast<void>(Clock::now());
    double const cost = std::chrono::duration<double, std::nano>(Clock::now() - begin).count() / reads;
    Finding f{"clock", State::ok, fmt::format("{}, {:.0f} ns a look", source, cost), ""};
    if (cost > 500) {  // a window looks at it some ten times
        f.state = State::warn;
        f.advice = "A slow clock: short windows pay for it. See clocksource= of the kernel's command line.";
    }
    return f;
}

Finding cores()
{
    cpu_set_t set;
    CPU_ZERO(&set);
    int const usable = ::sched_getaffinity(0, sizeof set, &set) == 0 ? CPU_COUNT(&set) : 1;
    double load[1] = {};
    if (::getloadavg(load, 1) != 1) load[0] = 0;
    Finding f{"cores", State::ok, fmt::format("{} usable, load {:.1f}", usable, load[0]), ""};
    if (usable < 2 || load[0] > usable) {
        f.state = State::warn;
        f.advice = usable < 2 ? "Participants take turns on one core."
                              : "Others are busy here: timings will not be yours alone.";
    }
    return f;
}

//! Where packings are kept between runs.
Finding cache()
{
    char const* const given = std::getenv("SLUICE_CACHE");
    char const* const home = std::getenv("HOME");
    std::filesystem::path const place = given ? given : std::filesystem::path(home ? home : "/nonexistent") / ".cache";
    auto there = place;
    while (!std::filesystem::exists(there) && there.has_parent_path() && there != there.parent_path())
        there = there.parent_path();
    bool const writable = (given || home) && ::access(there.c_str(), W_OK) == 0;
    auto const found = given || home ? place.string() : std::string("neither HOME nor SLUICE_CACHE is set");
    return {"cache", writable ? State::ok : State::warn,
            found + (writable || !(given || home) ? "" : ": cannot be written"),
            writable ? "" : "Columns are poured anew for every run: set SLUICE_CACHE to a directory."};
}

}  // namespace

std::vector<Finding> examine()
{
    return {{"sluice", State::ok, std::string(SLUICE_VERSION) + ", " + (own_directory() / "sluice").string(), ""},
            libraries(),
            solvers(),
            mpi(),
            shared_memory(),
            limit("open files", RLIMIT_NOFILE, 1, "files", 1024, "Many participants need more: ulimit -n 4096."),
            limit("locked memory", RLIMIT_MEMLOCK, mega, "MB", 1,
                  "Fast networks under MPI want more: ulimit -l unlimited."),
            python(),
            graphviz(),
            clock_source(),
            cores(),
            cache()};
}

}  // namespace sluice
