#include <cstdio>
#include <cstdlib>

#include "tests/conformance/transport_suite.hpp"

//! One side of the conformance suite over MPI: `mpirun -np 2 mpi_member`. Members are the ranks, in reverse order.
int main()
{
    char const* const rank = std::getenv("OMPI_COMM_WORLD_RANK");
    int const self = rank ? 1 - std::atoi(rank) : 0;
    try {
        auto const transport = sluice::make_mpi_transport({{"a", "b"}, self});
        suite::all(*transport, self);
        std::printf("member %d: conforms\n", self);
        return 0;
    } catch (std::exception const& e) {
        std::fprintf(stderr, "member %d: %s\n", self, e.what());
        std::_Exit(1);  // mpirun ends the other one
    }
}
