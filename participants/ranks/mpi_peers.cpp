#include "participants/ranks/mpi_peers.hpp"

#include <sched.h>

#include <algorithm>
#include <chrono>
#include <climits>
#include <string>
#include <thread>
#include <utility>

#include "coupler/base/error.hpp"
#include "participants/ranks/mpi_processes.hpp"

namespace ranks {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int tag = 1, tag_of_parcels = 2;
constexpr std::chrono::milliseconds short_wait{1}, longest_nap{10};

//! Until all are done. Process 0 may prepare a packing for minutes: a long wait naps, a twentieth of the time waited.
void wait_for(std::vector<MPI_Request>& requests)
{
    auto const start = Clock::now();
    for (int done = 0;;) {
        MPI_Testall(static_cast<int>(requests.size()), requests.data(), &done, MPI_STATUSES_IGNORE);
        if (done != 0) return;
        auto const waited = Clock::now() - start;
        if (waited < short_wait)
            ::sched_yield();
        else
            std::this_thread::sleep_for(std::min<Clock::duration>(waited / 20, longest_nap));
    }
}

class MpiPeers final : public Peers
{
 public:
    MpiPeers(int rank, int count) : rank_(rank), count_(count), processes_(rank, count) {}

    int rank() const override { return rank_; }
    int count() const override { return count_; }

    std::vector<Bytes> all_to_all(std::vector<Bytes> out) override
    {
        auto const peers = static_cast<std::size_t>(count_);
        std::vector<int> sent(peers), coming(peers);
        for (std::size_t p = 0; p < peers; ++p) {
            sluice::require(out[p].size() <= INT_MAX, [] {
                return sluice::Error("more than 2 GB for one process at a time (MPI's limit). Use more ranks.",
                                     sluice::Exit::io);
            });
            sent[p] = static_cast<int>(out[p].size());
        }
        std::vector<MPI_Request> requests(1);
        MPI_Ialltoall(sent.data(), 1, MPI_INT, coming.data(), 1, MPI_INT, comm_, requests.data());
        wait_for(requests);
        requests.clear();
        std::vector<Bytes> in(peers);
        for (std::size_t p = 0; p < peers; ++p) {
            if (static_cast<int>(p) == rank_) continue;
            in[p].resize(static_cast<std::size_t>(coming[p]));
            if (coming[p] > 0)
                MPI_Irecv(in[p].data(), coming[p], MPI_BYTE, static_cast<int>(p), tag, comm_, &requests.emplace_back());
            if (sent[p] > 0)
                MPI_Isend(out[p].data(), sent[p], MPI_BYTE, static_cast<int>(p), tag, comm_, &requests.emplace_back());
        }
        in[static_cast<std::size_t>(rank_)] = std::move(out[static_cast<std::size_t>(rank_)]);
        wait_for(requests);
        return in;
    }

    void start(std::span<Parcel> parcels) override
    {
        requests_.clear();
        for (Parcel& p : parcels) {
            auto const in = static_cast<int>(p.in.size()), out = static_cast<int>(p.out.size());
            MPI_Irecv(p.in.data(), in, MPI_DOUBLE, p.peer, tag_of_parcels, comm_, &requests_.emplace_back());
            MPI_Isend(p.out.data(), out, MPI_DOUBLE, p.peer, tag_of_parcels, comm_, &requests_.emplace_back());
        }
    }
    void finish() override
    {
        MPI_Waitall(static_cast<int>(requests_.size()), requests_.data(), MPI_STATUSES_IGNORE);
        requests_.clear();
    }

    std::vector<double> numbers(double mine) override
    {
        std::vector<double> all(static_cast<std::size_t>(count_));
        MPI_Allgather(&mine, 1, MPI_DOUBLE, all.data(), 1, MPI_DOUBLE, comm_);
        return all;
    }

 private:
    int rank_, count_;
    MpiProcesses processes_;
    MPI_Comm comm_ = processes_.comm();
    std::vector<MPI_Request> requests_;
};

}  // namespace

std::unique_ptr<Peers> mpi_peers(int rank, int count)
{
    return std::make_unique<MpiPeers>(rank, count);
}

}  // namespace ranks
