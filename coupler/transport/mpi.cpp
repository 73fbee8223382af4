#define OMPI_SKIP_MPICXX  // the deprecated C++ interface does not compile without warnings
#include <mpi.h>
#include <sched.h>

#include <climits>
#include <cstring>
#include <list>
#include <thread>

#include "coupler/base/error.hpp"
#include "coupler/transport/buffer.hpp"
#include "coupler/transport/transport.hpp"

namespace sluice {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int tag = 1;
constexpr auto spin = std::chrono::microseconds(30);  // then sleep: with two cores a spinning waiter takes a solver's
constexpr auto nap = std::chrono::microseconds(50);
constexpr int most_in_flight = 64;

class MpiTransport final : public Transport
{
 public:
    explicit MpiTransport(Members const& members) : rank_of_(members.names.size(), -1)
    {
        int provided = 0;
        MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &provided);
        try {
            meet(members);
        } catch (...) {
            MPI_Finalize();
            throw;
        }
    }

    ~MpiTransport() override
    {
        if (gave_up_) return;
        for (auto& sending : in_flight_) MPI_Wait(&sending.request, MPI_STATUS_IGNORE);
        MPI_Finalize();
    }

    std::span<std::byte> reserve(int /*peer*/, std::size_t size) override
    {
        collect_finished();
        if (in_flight_.size() >= most_in_flight) return {};
        if (!next_) next_ = take_spare();
        return next_->room(size);
    }

    bool commit(int peer, std::size_t size) override
    {
        require(size <= INT_MAX, [] { return Error("a message of more than 2 GB (MPI's limit).", Exit::io); });
        auto& sending = in_flight_.emplace_back();
        sending.buffer = std::move(next_);
        MPI_Isend(sending.buffer->data(), static_cast<int>(size), MPI_BYTE, rank_of_[static_cast<std::size_t>(peer)],
                  tag, MPI_COMM_WORLD, &sending.request);
        return true;
    }

    std::optional<Incoming> receive(std::chrono::microseconds patience) override
    {
        auto const start = Clock::now();
        for (;;) {
            int found = 0;
            MPI_Message message;
            MPI_Status status;
            MPI_Improbe(MPI_ANY_SOURCE, tag, MPI_COMM_WORLD, &found, &message, &status);
            if (found) return take(message, status);
            collect_finished();
            auto const waited = Clock::now() - start;
            if (waited >= patience) return std::nullopt;
            if (waited < spin)
                sched_yield();
            else
                std::this_thread::sleep_for(nap);
        }
    }

    bool lost(int) const override { return false; }  // mpirun ends the job when a rank dies
    std::string kind() const override { return "mpi"; }

    void give_up(int exit_code) override
    {
        gave_up_ = true;
        MPI_Abort(MPI_COMM_WORLD, exit_code);
    }

 private:
    struct Sending
    {
        std::shared_ptr<Buffer> buffer;
        MPI_Request request = MPI_REQUEST_NULL;
    };

    void meet(Members const& members)
    {
        int size = 0;
        MPI_Comm_size(MPI_COMM_WORLD, &size);
        std::vector<int> who(static_cast<std::size_t>(size));
        MPI_Allgather(&members.self, 1, MPI_INT, who.data(), 1, MPI_INT, MPI_COMM_WORLD);
        for (int rank = 0; rank < size; ++rank) {
            int& slot = rank_of_.at(static_cast<std::size_t>(who[static_cast<std::size_t>(rank)]));
            require(slot < 0, [&] {
                return Error("participant \"" + members.names[static_cast<std::size_t>(members.self)] +
                                 "\": a name was started twice in this mpirun.",
                             Exit::protocol);
            });
            slot = rank;
        }
        std::string missing;
        for (std::size_t p = 0; p < rank_of_.size(); ++p)
            if (rank_of_[p] < 0) missing += (missing.empty() ? "" : ", ") + members.names[p];
        require(missing.empty(), [&] {
            return Error("not in this mpirun: " + missing +
                             " (with transport: mpi all participants are started by one mpirun, as `sluice run` does).",
                         Exit::timeout);
        });
    }

    Incoming take(MPI_Message& message, MPI_Status const& status)
    {
        int count = 0;
        MPI_Get_count(&status, MPI_BYTE, &count);
        Incoming incoming;
        auto buffer = take_spare();
        auto const room = buffer->room(static_cast<std::size_t>(count));
        MPI_Mrecv(room.data(), count, MPI_BYTE, &message, MPI_STATUS_IGNORE);
        incoming.message = {room, std::move(buffer)};
        for (std::size_t p = 0; p < rank_of_.size(); ++p)
            if (rank_of_[p] == status.MPI_SOURCE) incoming.peer = static_cast<int>(p);
        return incoming;
    }

    //! A buffer that nobody else holds: of those in `buffers_` one that has come back, or a new one.
    std::shared_ptr<Buffer> take_spare()
    {
        for (auto const& buffer : buffers_)
            if (buffer.use_count() == 1) return buffer;
        return buffers_.emplace_back(std::make_shared<Buffer>());
    }

    void collect_finished()
    {
        for (auto it = in_flight_.begin(); it != in_flight_.end();) {
            int done = 0;
            MPI_Test(&it->request, &done, MPI_STATUS_IGNORE);
            it = done ? in_flight_.erase(it) : std::next(it);
        }
    }

    std::vector<int> rank_of_;
    std::list<Sending> in_flight_;
    std::vector<std::shared_ptr<Buffer>> buffers_;
    std::shared_ptr<Buffer> next_;
    bool gave_up_ = false;
};

}  // namespace

std::unique_ptr<Transport> make_mpi_transport(Members const& members)
{
    return std::make_unique<MpiTransport>(members);
}

}  // namespace sluice
