#include "coupler/base/team.hpp"

#include <algorithm>

namespace sluice {
namespace {

constexpr int short_spin = 1000;  //!< pauses, about 20 us
constexpr int long_spin = 6000;   //!< about 120 us

}  // namespace

//! Waits until `value` differs from `old`: spins, then sleeps in the kernel.
template <class T>
void Team::wait_change(std::atomic<T> const& value, T old) const
{
    for (int i = 0; i < short_spin || (i < long_spin && awake_.load(std::memory_order_relaxed)); ++i) {
        if (value.load(std::memory_order_acquire) != old) return;
#if defined(__x86_64__)
        __builtin_ia32_pause();
#endif
    }
    value.wait(old, std::memory_order_acquire);
}

Team::Team(int threads)
{
    for (int i = 1; i < threads; ++i) workers_.emplace_back([this] { work(); });
}

Team::~Team()
{
    stop_ = true;
    ++round_;
    round_.notify_all();
    for (std::thread& worker : workers_) worker.join();
}

void Team::share(std::ptrdiff_t count, std::ptrdiff_t chunk, Body const& body)
{
    count_ = count;
    chunk_ = chunk;
    body_ = &body;
    next_ = 0;
    if (workers_.empty() || count <= chunk) return take_chunks();
    busy_ = static_cast<int>(workers_.size());
    ++round_;
    round_.notify_all();
    take_chunks();
    for (int left = busy_; left != 0; left = busy_) wait_change(busy_, left);
}

void Team::take_chunks()
{
    for (std::ptrdiff_t begin = next_.fetch_add(chunk_); begin < count_; begin = next_.fetch_add(chunk_))
        (*body_)(begin, std::min(begin + chunk_, count_));
}

void Team::work()
{
    for (unsigned seen = 0;;) {
        wait_change(round_, seen);
        seen = round_;
        if (stop_) return;
        take_chunks();
        if (--busy_ == 0) busy_.notify_all();
    }
}

}  // namespace sluice
