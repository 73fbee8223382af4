#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <map>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <tuple>
#include <utility>
#include <vector>

#include "participants/ranks/peers.hpp"

//! Processes of one participant as threads of one process: no MPI is needed.
namespace unit {

//! What is on its way between all of them.
class Post
{
 public:
    enum Kind
    {
        others,
        parcels
    };
    void put(int from, int to, ranks::Bytes bytes, Kind kind = others)
    {
        std::lock_guard const lock(mutex_);
        way_[{kind, from, to}].push_back(std::move(bytes));
        news_.notify_all();
    }
    ranks::Bytes take(int from, int to, Kind kind = others)
    {
        std::unique_lock lock(mutex_);
        auto& waiting = way_[{kind, from, to}];
        news_.wait(lock, [&] { return closed_ || !waiting.empty(); });
        if (waiting.empty()) throw std::runtime_error("another process failed");
        ranks::Bytes bytes = std::move(waiting.front());
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
    std::map<std::tuple<Kind, int, int>, std::deque<ranks::Bytes>> way_;
    bool closed_ = false;
};

class ThreadPeers final : public ranks::Peers
{
 public:
    ThreadPeers(Post& post, int rank, int count) : post_(post), rank_(rank), count_(count) {}

    int rank() const override { return rank_; }
    int count() const override { return count_; }
    std::vector<ranks::Bytes> all_to_all(std::vector<ranks::Bytes> out) override
    {
        for (int p = 0; p < count_; ++p) post_.put(rank_, p, std::move(out.at(static_cast<std::size_t>(p))));
        std::vector<ranks::Bytes> in;
        for (int p = 0; p < count_; ++p) in.push_back(post_.take(p, rank_));
        return in;
    }
    void start(std::span<ranks::Parcel> parcels) override
    {
        started_ = parcels;
        for (auto const& parcel : parcels) {
            auto const bytes = std::as_bytes(std::span(parcel.out));
            post_.put(rank_, parcel.peer, {bytes.begin(), bytes.end()}, Post::parcels);
        }
    }
    void finish() override
    {
        for (auto& parcel : started_) {
            auto const bytes = post_.take(parcel.peer, rank_, Post::parcels);
            if (bytes.size() != parcel.in.size() * sizeof(double)) throw std::runtime_error("sides disagree");
            if (!bytes.empty()) std::memcpy(parcel.in.data(), bytes.data(), bytes.size());
        }
        started_ = {};
    }
    std::vector<double> numbers(double mine) override { return ranks::everyone(*this, mine); }

 private:
    Post& post_;
    int rank_, count_;
    std::span<ranks::Parcel> started_{};
};

//! Runs `body` on so many processes. Throws what the first that failed threw.
inline void on_processes(int count, std::function<void(ranks::Peers&)> const& body)
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

//! What the first of so many processes has in the end of what body(peers, its own) fills in.
template <class Trace, class Body>
Trace of_first(int processes, Body&& body)
{
    Trace first;
    on_processes(processes, [&](ranks::Peers& peers) {
        Trace mine;
        body(peers, mine);
        if (peers.rank() == 0) first = std::move(mine);
    });
    return first;
}

//! Of each scene (with a name, `what`), what one leaves alone, a vector, is what the first of so many processes leaves.
template <class Scene, class Alone, class Shared>
void check_bits_of_one(std::vector<Scene> const& scenes, std::vector<int> const& processes, Alone&& alone,
                       Shared&& shared)
{
    for (Scene const& scene : scenes) {
        CAPTURE(scene.what);
        auto const one = alone(scene);
        for (int const count : processes) {
            CAPTURE(count);
            auto const many = shared(scene, count);
            REQUIRE(many.size() == one.size());
            CHECK(std::mismatch(one.begin(), one.end(), many.begin()).first == one.end());
        }
    }
}

}  // namespace unit
