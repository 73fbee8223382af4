#include <cstdio>
#include <cstdlib>
#include <stdexcept>

#include "participants/ranks/mpi_peers.hpp"
#include "tests/participants/dem/domain_scenes.hpp"

//! One process of grains that are shared out over MPI: `mpirun -np N mpi_peers_member`. A collapse gives the bits of
//! one process.
namespace {

void require(bool ok, char const* what)
{
    if (!ok) throw std::runtime_error(what);
}

//! Each process to each: as many bytes as their ranks make, some none.
void exchange_bytes(ranks::Peers& peers)
{
    auto const size = [&](int from, int to) { return static_cast<std::size_t>((from + to) % 3 * 1000); };
    std::vector<ranks::Bytes> out;
    for (int p = 0; p < peers.count(); ++p)
        out.emplace_back(size(peers.rank(), p), static_cast<std::byte>(10 * peers.rank() + p));
    auto const in = peers.all_to_all(out);
    for (int p = 0; p < peers.count(); ++p)
        require(in.at(static_cast<std::size_t>(p)) ==
                    ranks::Bytes(size(p, peers.rank()), static_cast<std::byte>(10 * p + peers.rank())),
                "all_to_all brings other bytes");
    std::vector<double> numbers;
    for (int p = 0; p < peers.count(); ++p) numbers.push_back(0.1 * p);
    require(peers.numbers(0.1 * peers.rank()) == numbers, "other numbers came");
}

void run_collapse(ranks::Peers& peers)
{
    auto const start = unit::collapse();
    int const steps = 3000;
    dem::Solver<2> solver = peers.rank() == 0 ? start : dem::Solver<2>(start.setup(), {});
    solver.share_out(peers);
    for (int n = 0; n < steps; ++n) solver.step(unit::step);
    auto const whole = solver.whole();
    if (peers.rank() != 0) return;
    dem::Solver<2> one = start;
    for (int n = 0; n < steps; ++n) one.step(unit::step);
    require(unit::without_sums(whole) == unit::without_sums(one.state()), "the bits are not those of one process");
    require(whole.rebuilds > 5, "nothing was rebuilt");
}

int number(char const* name)
{
    char const* const text = std::getenv(name);
    return text ? std::atoi(text) : 0;
}

}  // namespace

int main()
{
    int const rank = number("OMPI_COMM_WORLD_RANK"), size = number("OMPI_COMM_WORLD_SIZE");
    try {
        auto const peers = ranks::mpi_peers(rank, size);
        exchange_bytes(*peers);
        run_collapse(*peers);
        std::printf("process %d of %d: as one\n", rank, size);
        return 0;
    } catch (std::exception const& e) {
        std::fprintf(stderr, "process %d: %s\n", rank, e.what());
        std::_Exit(1);  // mpirun ends the others
    }
}
