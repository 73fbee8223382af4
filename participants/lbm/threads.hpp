#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <thread>
#include <vector>

namespace lbm {

//! A fixed team of threads that share loops. Idle threads spin for some microseconds, then sleep: other participants
//! of the run need the cores. What a loop body writes must depend on its index alone; then the number of threads
//! cannot change a result.
class Team
{
 public:
    using Body = std::function<void(std::ptrdiff_t begin, std::ptrdiff_t end)>;

    explicit Team(int threads);  //!< the calling thread is one of them
    ~Team();
    Team(Team const&) = delete;
    Team& operator=(Team const&) = delete;

    int size() const noexcept { return static_cast<int>(workers_.size()) + 1; }
    //! Runs body on [0, count) in chunks, handed out as threads become free; returns when all are done. body must not
    //! throw.
    void share(std::ptrdiff_t count, std::ptrdiff_t chunk, Body const& body);

 private:
    void work();
    void take_chunks();

    std::vector<std::thread> workers_;
    std::atomic<unsigned> round_{0};  //!< changes when there is a loop to share
    std::atomic<int> busy_{0};        //!< workers that have not finished the round
    std::atomic<bool> stop_{false};
    std::atomic<std::ptrdiff_t> next_{0};
    std::ptrdiff_t count_ = 0, chunk_ = 1;
    Body const* body_ = nullptr;
};

}  // namespace lbm
