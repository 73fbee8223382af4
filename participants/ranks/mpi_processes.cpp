#include "participants/ranks/mpi_processes.hpp"

#include <exception>
#include <string>

#include "coupler/base/error.hpp"

namespace ranks {
namespace {

constexpr int tag = 1;

}  // namespace

MpiProcesses::MpiProcesses(int rank, int count) : unwinding_(std::uncaught_exceptions())
{
    int begun = 0, provided = 0, world_rank = 0, world_size = 0;
    MPI_Initialized(&begun);
    ours_ = begun == 0;
    if (ours_) MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &provided);
    MPI_Comm_rank(MPI_COMM_WORLD, &world_rank);
    MPI_Comm_size(MPI_COMM_WORLD, &world_size);
    int const first = world_rank - rank;  // mpirun numbers the processes of a program one after the other
    sluice::require(first >= 0 && first + count <= world_size, [&] {
        return sluice::Error("process " + std::to_string(rank) + " of " + std::to_string(count) +
                             " was not started with the others (needed: mpirun -np " + std::to_string(count) +
                             ", as `sluice run` does).");
    });
    MPI_Group world = MPI_GROUP_NULL, own = MPI_GROUP_NULL;
    MPI_Comm_group(MPI_COMM_WORLD, &world);
    int range[1][3] = {{first, first + count - 1, 1}};
    MPI_Group_range_incl(world, 1, range, &own);
    MPI_Comm_create_group(MPI_COMM_WORLD, own, tag, &comm_);
    MPI_Group_free(&own);
    MPI_Group_free(&world);
}

MpiProcesses::~MpiProcesses()
{
    if (std::uncaught_exceptions() > unwinding_) return;
    MPI_Comm_free(&comm_);
    if (ours_) MPI_Finalize();
}

}  // namespace ranks
