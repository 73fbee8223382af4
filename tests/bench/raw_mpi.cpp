#define OMPI_SKIP_MPICXX  // the deprecated C++ interface does not compile without warnings
#include <mpi.h>

#include <cstring>

#include "tests/bench/raw.hpp"

namespace bench {
namespace {

constexpr int tag = 7;  // the transport, which may be there too, has another one

//! The solver's copy in and out is MPI's own nowhere: without it the same unchanged bytes would be sent again and
//! again, from cache to cache, which no solver does.
class RawMpi final : public Way
{
 public:
    explicit RawMpi(Setting const& setting)
        : side_(setting.side),
          field_(setting.most_points),
          sent_(setting.most_points),
          copy_(setting.most_points),
          received_(setting.most_points)
    {}

    void round_trip(std::size_t points) override
    {
        if (side_ == 0) send(points);
        auto const room = copy_.of(points);
        MPI_Recv(room.data(), static_cast<int>(room.size()), MPI_BYTE, 1 - side_, tag, MPI_COMM_WORLD,
                 MPI_STATUS_IGNORE);
        std::memcpy(received_.of(points).data(), room.data(), room.size());
        if (side_ == 1) send(points);
    }

 private:
    void send(std::size_t points)
    {
        auto const bytes = sent_.of(points);
        std::memcpy(bytes.data(), field_.of(points).data(), bytes.size());
        MPI_Send(bytes.data(), static_cast<int>(bytes.size()), MPI_BYTE, 1 - side_, tag, MPI_COMM_WORLD);
    }

    int side_;
    Field field_, sent_, copy_, received_;
};

}  // namespace

std::unique_ptr<Way> raw_mpi(Setting const& setting)
{
    return std::make_unique<RawMpi>(setting);
}

}  // namespace bench
