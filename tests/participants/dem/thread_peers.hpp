#pragma once

#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <map>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#include "participants/dem/peers.hpp"

//! Processes that share grains, as threads of one process: no MPI is needed.
namespace unit {

//! What is on its way between all of them.
class Post
{
 public:
    void put(int from, int to, dem::Bytes bytes)
    {
        std::lock_guard const lock(mutex_);
        way_[{from, to}].push_back(std::move(bytes));
        news_.notify_all();
    }
    dem::Bytes take(int from, int to)
    {
        std::unique_lock lock(mutex_);
        auto& waiting = way_[{from, to}];
        news_.wait(lock, [&] { return closed_ || !waiting.empty(); });
        if (waiting.empty()) throw std::runtime_error("another process failed");
        dem::Bytes bytes = std::move(waiting.front());
        waiting.pop_front();
        return bytes;
    }
    void close()
    {
        std::lock_guard const lock(mutex_);
        closed_ = true;
        news_.notify_all();
    }

 private:
    std::mutex mutex_;
    std::condition_variable news_;
    std::map<std::pair<int, int>, std::deque<dem::Bytes>> way_;
    bool closed_ = false;
};

class ThreadPeers final : public dem::Peers
{
 public:
    ThreadPeers(Post& post, int rank, int count) : post_(post), rank_(rank), count_(count) {}

    int rank() const override { return rank_; }
    int count() const override { return count_; }
    std::vector<dem::Bytes> all_to_all(std::vector<dem::Bytes> out) override
    {
        for (int p = 0; p < count_; ++p) post_.put(rank_, p, std::move(out.at(static_cast<std::size_t>(p))));
        std::vector<dem::Bytes> in;
        for (int p = 0; p < count_; ++p) in.push_back(post_.take(p, rank_));
        return in;
    }
    void swap(std::span<dem::Parcel> parcels) override
    {
        for (auto const& parcel : parcels) {
            auto const bytes = std::as_bytes(std::span(parcel.out));
            post_.put(rank_, parcel.peer, {bytes.begin(), bytes.end()});
        }
        for (auto& parcel : parcels) {
            auto const bytes = post_.take(parcel.peer, rank_);
            if (bytes.size() != parcel.in.size() * sizeof(double)) throw std::runtime_error("sides disagree");
            if (!bytes.empty()) std::memcpy(parcel.in.data(), bytes.data(), bytes.size());
        }
    }
    std::vector<double> numbers(double mine) override { return dem::everyone(*this, mine); }

 private:
    Post& post_;
    int rank_, count_;
};

//! Runs `body` on so many processes. Throws what the first that failed threw.
inline void on_processes(int count, std::function<void(dem::Peers&)> const& body)
{
    Post post;
    std::mutex mutex;
    std::exception_ptr failure;
    std::vector<std::thread> threads;
    for (int rank = 0; rank < count; ++rank)
        threads.emplace_back([&, rank] {
            try {
                ThreadPeers peers(post, rank, count);
                body(peers);
            } catch (...) {
                std::lock_guard const lock(mutex);
                if (!failure) failure = std::current_exception();
                post.close();
            }
        });
    for (auto& thread : threads) thread.join();
    if (failure) std::rethrow_exception(failure);
}

}  // namespace unit
