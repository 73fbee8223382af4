#include "participants/liggghts/engine.hpp"

#include "participants/ranks/mpi_processes.hpp"  // brings MPI, as LIGGGHTS' headers need it
//
#include <fix_external.h>
#include <force.h>
#include <lammps.h>
#include <library.h>
#include <modify.h>
#include <pair.h>
#include <update.h>

#include <array>
#include <chrono>
#include <exception>
#include <limits>
#include <utility>

#include "coupler/base/error.hpp"
#include "participants/liggghts/stopped.hpp"

namespace liggghts {
namespace {

using Clock = std::chrono::steady_clock;

constexpr char const* fix_name = "sluice";  // that brings the loads
// of steps in which the fix adds what it keeps to the forces: never, but at step 0; push adds by itself
constexpr int apart = std::numeric_limits<int>::max();

double since(Clock::time_point start)
{
    return std::chrono::duration<double>(Clock::now() - start).count();
}

}  // namespace

struct Engine::Library
{
    ranks::MpiProcesses processes;
    LAMMPS_NS::LAMMPS* lammps = nullptr;
    std::filesystem::path log;
    Push push;
    std::exception_ptr thrown;  //!< by push: it cannot pass through a run
    bool broken = false;        //!< gave up: cannot be closed any more
    Times times;

    Library(std::filesystem::path file, int rank, int ranks) : processes(rank, ranks), log(std::move(file))
    {
        std::array<std::string, 7> words{"liggghts", "-log", log.string(), "-screen", "none", "-echo", "log"};
        std::array<char*, 7> argv{};
        for (std::size_t k = 0; k < words.size(); ++k) argv[k] = words[k].data();
        void* opened = nullptr;
        lammps_open(static_cast<int>(argv.size()), argv.data(), processes.comm(), &opened);
        lammps = static_cast<LAMMPS_NS::LAMMPS*>(opened);
    }
    ~Library()
    {
        set_warning_file(nullptr);
        if (!broken) lammps_close(lammps);
    }
    Library(Library const&) = delete;
    Library& operator=(Library const&) = delete;

    //! What an atom has, by LIGGGHTS' name of it.
    template <class Value>
    Value* atoms(char const* name) const
    {
        return static_cast<Value*>(lammps_extract_atom(lammps, name));
    }

    static void take_loads(void* self, LAMMPS_NS::bigint step, int count, int*, double**, double** kept)
    {
        auto const start = Clock::now();
        auto& library = *static_cast<Library*>(self);
        if (step % apart == 0)
            for (int i = 0; i < count; ++i)
                for (int k = 0; k < 3; ++k) kept[i][k] = 0.0;
        if (library.thrown) return;
        try {
            library.push(library.rows());
        } catch (...) {
            library.thrown = std::current_exception();
        }
        library.times.push += since(start);
    }

    Rows rows() const
    {
        Rows r;
        r.count = *static_cast<int*>(lammps_extract_global(lammps, "nlocal"));
        r.tag = atoms<int>("id");
        r.place = atoms<double*>("x");
        r.velocity = atoms<double*>("v");
        r.spin = atoms<double*>("omega");
        r.radius = atoms<double>("radius");
        r.mass = atoms<double>("rmass");
        r.force = atoms<double*>("f");
        r.torque = atoms<double*>("torque");
        return r;
    }

    void command(std::string const& text, std::string const& where, sluice::Exit exit)
    {
        try {
            lammps_command(lammps, text.c_str());
        } catch (Stopped const& stopped) {
            broken = true;
            throw sluice::Error(where + ": LIGGGHTS stops: " + stopped.text + " (at: " + text.substr(0, 200) +
                                    "). What came before is in " + log.string() + ".",
                                exit);
        }
        if (thrown) std::rethrow_exception(std::exchange(thrown, nullptr));
    }

    //! A run of the grains, without a word in the log.
    void run(std::string const& text)
    {
        std::FILE* const file = std::exchange(lammps->logfile, nullptr);
        set_warning_file(file);
        auto const back = [&] {
            lammps->logfile = file;
            set_warning_file(nullptr);
        };
        try {
            command(text, "while it computes", sluice::Exit::numerical);
        } catch (...) {
            back();
            throw;
        }
        back();
    }
};

Engine::Engine(std::filesystem::path const& log, int rank, int ranks)
    : library_(std::make_unique<Library>(log, rank, ranks))
{}
Engine::~Engine() = default;

void Engine::command(std::string const& text, std::string const& where)
{
    library_->command(text, where, sluice::Exit::config);
}

void Engine::couple(Push push)
{
    library_->push = std::move(push);
    command(std::string("fix ") + fix_name + " all external pf/callback 1 " + std::to_string(apart),
            "loads of partners");
    auto* const modify = library_->lammps->modify;
    static_cast<LAMMPS_NS::FixExternal*>(modify->fix[modify->find_fix(fix_name)])
        ->set_callback(&Library::take_loads, library_.get());
    evaluate();
}

void Engine::evaluate()
{
    library_->run("run 0 post no");
}

void Engine::run(std::int64_t steps, double dt)
{
    LAMMPS_NS::LAMMPS const& lammps = *library_->lammps;
    if (dt != lammps.update->dt) {  // as its fix dt/reset does
        lammps.update->dt = dt;
        for (int k = 0; k < lammps.modify->nfix; ++k) lammps.modify->fix[k]->reset_dt();
        if (lammps.force->pair) lammps.force->pair->reset_dt();
    }
    auto const start = Clock::now();
    double const pushed = library_->times.push;
    library_->run("run " + std::to_string(steps) + " pre no post no");
    library_->times.own += since(start) - (library_->times.push - pushed);
}

Rows Engine::rows() const
{
    return library_->rows();
}

void Engine::sum(double* numbers, std::size_t count) const
{
    MPI_Allreduce(MPI_IN_PLACE, numbers, static_cast<int>(count), MPI_DOUBLE, MPI_SUM, library_->processes.comm());
}

std::int64_t Engine::largest(std::int64_t number) const
{
    MPI_Allreduce(MPI_IN_PLACE, &number, 1, MPI_INT64_T, MPI_MAX, library_->processes.comm());
    return number;
}

void Engine::share(std::vector<std::int64_t>& numbers) const
{
    MPI_Comm const comm = library_->processes.comm();
    auto count = static_cast<std::int64_t>(numbers.size());
    MPI_Bcast(&count, 1, MPI_INT64_T, 0, comm);
    numbers.resize(static_cast<std::size_t>(count));
    MPI_Bcast(numbers.data(), static_cast<int>(count), MPI_INT64_T, 0, comm);
}

Engine::Times Engine::times() const
{
    return library_->times;
}

}  // namespace liggghts
