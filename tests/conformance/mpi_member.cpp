#include <cstdio>
#include <cstdlib>

#include "tests/conformance/transport_suite.hpp"

//! One member of the conformance suite over MPI: `mpirun -np 2 mpi_member` runs the conversation of two, `-np 3` all to
//! all among the processes of two participants. Members are the ranks, in reverse order.
int main()
{
    char const* const rank = std::getenv("OMPI_COMM_WORLD_RANK");
    char const* const size = std::getenv("OMPI_COMM_WORLD_SIZE");
    int const count = size ? std::atoi(size) : 1, self = count - 1 - (rank ? std::atoi(rank) : 0);
    try {
        if (count == 3) {
            auto const transport = sluice::make_mpi_transport({{"grains", "water:0", "water:1"}, self});
            suite::all_to_all(*transport, self, count);
        } else {
            auto const transport = sluice::make_mpi_transport({{"a", "b"}, self});
            suite::all(*transport, self);
        }
        std::printf("member %d: conforms\n", self);
        return 0;
    } catch (std::exception const& e) {
        std::fprintf(stderr, "member %d: %s\n", self, e.what());
        std::_Exit(1);  // mpirun ends the other one
    }
}
