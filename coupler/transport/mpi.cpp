#define OMPI_SKIP_MPICXX  // the deprecated C++ interface does not compile without warnings
#include <mpi.h>
#include <sys/prctl.h>

#include <algorithm>
#include <array>
#include <climits>
#include <thread>

#include "coupler/base/error.hpp"
#include "coupler/transport/buffer.hpp"
#include "coupler/transport/spin.hpp"
#include "coupler/transport/transport.hpp"

namespace sluice {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::microseconds;

constexpr int tag = 1;
constexpr int most_in_flight = 64;
constexpr microseconds longest_nap{10'000};         // 100 looks a second: an idle wait costs next to nothing
constexpr microseconds root_time{500'000};          // for a peer that has said why it stops to end with its own code
constexpr std::chrono::seconds time_to_finish{10};  // for what is still on its way when the transport ends

//! Messages that MPI has not let go of yet, in the order in which they were sent.
class Sendings
{
 public:
    bool full() const { return count_ == most_in_flight; }
    bool empty() const { return count_ == 0; }

    void start(std::shared_ptr<Buffer> buffer, std::size_t size, int rank)
    {
        MPI_Isend(buffer->data(), static_cast<int>(size), MPI_BYTE, rank, tag, MPI_COMM_WORLD, &requests_[count_]);
        buffers_[count_++] = std::move(buffer);
    }

    void collect_finished()
    {
        if (empty()) return;
        int done = 0;
        MPI_Testsome(static_cast<int>(count_), requests_.data(), &done, indices_.data(), MPI_STATUSES_IGNORE);
        if (done <= 0) return;
        std::size_t kept = 0;
        for (std::size_t i = 0; i < count_; ++i) {
            if (requests_[i] == MPI_REQUEST_NULL) {  // set by MPI_Testsome
                buffers_[i].reset();
            } else {
                std::swap(requests_[kept], requests_[i]);
                std::swap(buffers_[kept++], buffers_[i]);
            }
        }
        count_ = kept;
    }

 private:
    std::size_t count_ = 0;
    std::array<MPI_Request, most_in_flight> requests_{};
    std::array<std::shared_ptr<Buffer>, most_in_flight> buffers_{};
    std::array<int, most_in_flight> indices_{};
};

class MpiTransport final : public Transport
{
 public:
    explicit MpiTransport(Members const& members) : rank_of_(members.names.size(), -1)
    {
        start_mpi();
        ::prctl(PR_SET_TIMERSLACK, 1000UL);  // ns; naps are of microseconds, and the kernel adds 50 us if nobody asks
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
        auto const start = Clock::now();
        for (sendings_.collect_finished(); !sendings_.empty(); sendings_.collect_finished()) {
            auto const waited = Clock::now() - start;
            if (waited > time_to_finish) break;  // a peer that takes nothing in: mpirun ends the job if it died
            nap(waited, time_to_finish);
        }
        MPI_Finalize();
    }

    std::span<std::byte> reserve(int /*peer*/, std::size_t size) override
    {
        sendings_.collect_finished();
        if (sendings_.full()) return {};
        if (!next_) next_ = pool_.take();
        return next_->room(size);
    }

    bool commit(int peer, std::size_t size) override
    {
        require(size <= INT_MAX, [] { return Error("a message of more than 2 GB (MPI's limit).", Exit::io); });
        sendings_.start(std::move(next_), size, rank_of_[static_cast<std::size_t>(peer)]);
        return true;
    }

    std::optional<Incoming> receive(microseconds patience) override
    {
        if (auto incoming = look()) {
            spin_.found();
            return incoming;
        }
        auto now = Clock::now();
        auto const start = now, deadline = now + patience;
        spin_.begin(now);
        for (;;) {
            sendings_.collect_finished();
            if (auto incoming = look()) {
                spin_.found(Clock::now());
                return incoming;
            }
            now = Clock::now();
            if (now >= deadline) {
                spin_.gave_up(now);
                return std::nullopt;
            }
            if (!spin_.again(now)) nap(spin_.waited() + (now - start), deadline - now);
        }
    }

    bool lost(int) const override { return false; }  // mpirun ends the job when a rank dies
    std::string kind() const override { return "mpi"; }

    void give_up(int exit_code) override
    {
        gave_up_ = true;
        // whoever stopped first is about to say so, with its own code: the first abort is the one that mpirun reports
        if (exit_code == static_cast<int>(Exit::peer_died)) std::this_thread::sleep_for(root_time);
        MPI_Abort(MPI_COMM_WORLD, exit_code);
    }

 private:
    //! A twentieth of the time waited so far: no message is late by more than that, and a long wait costs little.
    static void nap(Clock::duration waited, Clock::duration left)
    {
        std::this_thread::sleep_for(std::min<Clock::duration>({waited / 20, longest_nap, left}));
    }

    void meet(Members const& members)
    {
        int size = 0;
        MPI_Comm_size(MPI_COMM_WORLD, &size);
        std::vector<int> who(static_cast<std::size_t>(size));
        MPI_Request gathering = MPI_REQUEST_NULL;
        MPI_Iallgather(&members.self, 1, MPI_INT, who.data(), 1, MPI_INT, MPI_COMM_WORLD, &gathering);
        int all = 0;
        for (auto const start = Clock::now(); MPI_Test(&gathering, &all, MPI_STATUS_IGNORE), all == 0;)
            nap(Clock::now() - start, longest_nap);
        for (int rank = 0; rank < size; ++rank) {
            int& slot = rank_of_.at(static_cast<std::size_t>(who[static_cast<std::size_t>(rank)]));
            require(slot < 0, [&] {
                return Error("participant \"" + members.names[static_cast<std::size_t>(members.self)] +
                                 "\": a name was started twice in this mpirun.",
                             Exit::protocol);
            });
            slot = rank;
        }
        spin_.set_crowded(crowded(size));
        std::string missing;
        for (std::size_t p = 0; p < rank_of_.size(); ++p)
            if (rank_of_[p] < 0) missing += (missing.empty() ? "" : ", ") + members.names[p];
        require(missing.empty(), [&] {
            return Error("not in this mpirun: " + missing +
                             " (with transport: mpi all participants are started by one mpirun, as `sluice run` does).",
                         Exit::timeout);
        });
    }

    std::optional<Incoming> look()
    {
        int found = 0, count = 0;
        MPI_Message message;
        MPI_Status status;
        MPI_Improbe(MPI_ANY_SOURCE, tag, MPI_COMM_WORLD, &found, &message, &status);
        if (!found) return std::nullopt;
        MPI_Get_count(&status, MPI_BYTE, &count);
        auto buffer = pool_.take();
        auto const room = buffer->room(static_cast<std::size_t>(count));
        MPI_Mrecv(room.data(), count, MPI_BYTE, &message, MPI_STATUS_IGNORE);  // it is matched: only its bytes are due
        auto const sender = std::find(rank_of_.begin(), rank_of_.end(), status.MPI_SOURCE);
        return Incoming{static_cast<int>(sender - rank_of_.begin()), {room, std::move(buffer)}};
    }

    std::vector<int> rank_of_;
    BufferPool pool_;
    Sendings sendings_;
    std::shared_ptr<Buffer> next_;
    Spin spin_;
    bool gave_up_ = false;
};

}  // namespace

void start_mpi()
{
    int begun = 0, provided = 0;
    MPI_Initialized(&begun);
    if (begun == 0) MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &provided);
}

std::unique_ptr<Transport> make_mpi_transport(Members const& members)
{
    return std::make_unique<MpiTransport>(members);
}

}  // namespace sluice
