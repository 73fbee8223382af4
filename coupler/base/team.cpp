#include "coupler/base/team.hpp"

#include <algorithm>

namespace sluice {
namespace {

constexpr int short_spin = 1000;  //!< pauses, about 20 us
constexpr int long_spin = 6000;   //!< about 120 us

constexpr std::uint64_t no_chunk = 0xffffffff;  //!< as the next one of a round that has not begun

std::uint64_t first_of(unsigned round, std::uint64_t chunk)
{
    return std::uint64_t{round} << 32 | chunk;
}

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
    if (workers_.empty() || count <= chunk) {
        for (std::ptrdiff_t begin = 0; begin < count; begin += chunk) body(begin, std::min(begin + chunk, count));
        return;
    }
    unsigned const round = round_ + 1;
    next_ = first_of(round, no_chunk);  // who comes late from the last loop finds nothing while these are written
    count_ = count;
    chunk_ = chunk;
    body_ = &body;
    left_ = static_cast<int>((count + chunk - 1) / chunk);
    next_ = first_of(round, 0);
    round_ = round;
    round_.notify_all();
    take_chunks();
    for (int left = left_; left != 0; left = left_) wait_change(left_, left);
}

void Team::take_chunks()
{
    for (;;) {
        std::uint64_t at = next_;
        std::uint64_t const index = at & no_chunk;
        std::ptrdiff_t const count = count_, chunk = chunk_;
        // of the next loop, if these have changed since: then `at` has, too, and the exchange fails
        std::ptrdiff_t const begin = static_cast<std::ptrdiff_t>(index) * chunk;
        if (index == no_chunk || begin >= count) return;
        if (!next_.compare_exchange_weak(at, at + 1)) continue;
        (*body_)(begin, std::min(begin + chunk, count));
        if (--left_ == 0) left_.notify_all();
    }
}

void Team::work()
{
    for (unsigned seen = 0;;) {
        wait_change(round_, seen);
        seen = round_;
        if (stop_) return;
        take_chunks();
    }
}

}  // namespace sluice
