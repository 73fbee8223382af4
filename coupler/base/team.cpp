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

Team::Team(int threads) : parts_(static_cast<std::size_t>(std::max(threads, 1)))
{
    for (std::size_t i = 1; i < parts_.size(); ++i) workers_.emplace_back([this, i] { work(i); });
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
    for (Part& part : parts_)  // who comes late from the last loop finds nothing while these are written
        part.next = first_of(round, no_chunk);
    count_ = count;
    chunk_ = chunk;
    body_ = &body;
    left_ = static_cast<int>(chunks());
    for (std::size_t i = 0; i < parts_.size(); ++i)
        parts_[i].next = first_of(round, static_cast<std::uint64_t>(begin_of(i)));
    round_ = round;
    round_.notify_all();
    take_chunks(0);
    for (int left = left_; left != 0; left = left_) wait_change(left_, left);
}

//! Its own part first.
void Team::take_chunks(std::size_t self)
{
    for (std::size_t i = 0; i < parts_.size(); ++i)
        while (take_chunk((self + i) % parts_.size())) {
        }
}

//! Runs one chunk of a part, unless there is none left.
bool Team::take_chunk(std::size_t part)
{
    std::atomic<std::uint64_t>& next = parts_[part].next;
    for (;;) {
        std::uint64_t at = next;
        std::uint64_t const index = at & no_chunk;
        std::ptrdiff_t const count = count_, chunk = chunk_, end = begin_of(part + 1);
        // of the next loop, if these have changed since: then `at` has, too, and the exchange fails
        auto const taken = static_cast<std::ptrdiff_t>(index);
        if (index == no_chunk || taken >= end) return false;
        if (!next.compare_exchange_weak(at, at + 1)) continue;
        (*body_)(taken * chunk, std::min((taken + 1) * chunk, count));
        if (--left_ == 0) left_.notify_all();
        return true;
    }
}

void Team::work(std::size_t self)
{
    for (unsigned seen = 0;;) {
        wait_change(round_, seen);
        seen = round_;
        if (stop_) return;
        take_chunks(self);
    }
}

}  // namespace sluice
