#pragma once

#define OMPI_SKIP_MPICXX  // the deprecated C++ interface does not compile without warnings
#include <mpi.h>

namespace ranks {

//! MPI, begun if it is not, and a communicator of the processes of this participant alone.
class MpiProcesses
{
 public:
    //! `rank` of `count`. Throws sluice::Error if they were not started together.
    MpiProcesses(int rank, int count);
    //! After an error the others are not waited for: mpirun ends them.
    ~MpiProcesses();
    MpiProcesses(MpiProcesses const&) = delete;
    MpiProcesses& operator=(MpiProcesses const&) = delete;

    MPI_Comm comm() const { return comm_; }

 private:
    int unwinding_;  //!< exceptions on their way when this was made
    bool ours_ = false;
    MPI_Comm comm_ = MPI_COMM_NULL;
};

}  // namespace ranks
