#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <thread>
#include <vector>

namespace sluice {

//! A fixed team of threads that share loops. Idle threads spin for some microseconds, then sleep: other participants
//! of the run need the cores. While someone holds them awake they spin longer (0.1 ms). What a loop body writes must
//! depend on its index alone; then the number of threads cannot change a result.
class Team
{
 public:
    using Body = std::function<void(std::ptrdiff_t begin, std::ptrdiff_t end)>;

    explicit Team(int threads);  //!< the calling thread is one of them
    ~Team();
    Team(Team const&) = delete;
    Team& operator=(Team const&) = delete;

    int size() const noexcept { return static_cast<int>(workers_.size()) + 1; }
    //! Runs body on [0, count) in chunks: each thread goes through a part of its own, the same in loops of one size,
    //! and then helps where chunks are left. What it works on stays in its cache, and what the machine fetches ahead is
    //! its own. Returns when all are done, and does not wait for a thread that has none of them, as one may that has no
    //! core yet. body must not throw.
    void share(std::ptrdiff_t count, std::ptrdiff_t chunk, Body const& body);

    //! While it lives, loops follow each other closely: a thread that waits for the next one does not go to sleep,
    //! which would cost a wake-up (50 us) each. To be held through one step, never while waiting for somebody else.
    class Awake
    {
     public:
        explicit Awake(Team& team) : team_(team) { team_.awake_ = true; }
        ~Awake() { team_.awake_ = false; }
        Awake(Awake const&) = delete;
        Awake& operator=(Awake const&) = delete;

     private:
        Team& team_;
    };

 private:
    template <class T>
    void wait_change(std::atomic<T> const& value, T old) const;
    //! Where one thread's part goes on.
    struct alignas(64) Part
    {
        std::atomic<std::uint64_t> next{0};  //!< round in the upper half, chunk that is taken next in the lower one
    };

    void work(std::size_t self);
    void take_chunks(std::size_t self);
    bool take_chunk(std::size_t part);
    std::ptrdiff_t chunks() const noexcept { return (count_ + chunk_ - 1) / chunk_; }
    //! The first chunk of a thread's part, and of what comes after the last one's.
    std::ptrdiff_t begin_of(std::size_t part) const noexcept
    {
        return chunks() * static_cast<std::ptrdiff_t>(part) / static_cast<std::ptrdiff_t>(parts_.size());
    }

    std::vector<Part> parts_;  //!< of the calling thread, and of each worker
    std::vector<std::thread> workers_;
    std::atomic<unsigned> round_{0};  //!< changes when there is a loop to share
    std::atomic<bool> stop_{false}, awake_{false};
    std::atomic<std::ptrdiff_t> count_{0}, chunk_{1};
    std::atomic<int> left_{0};  //!< chunks that are not done
    Body const* body_ = nullptr;
};

}  // namespace sluice
