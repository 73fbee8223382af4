#include "coupler/transport/shm_bell.hpp"

#include <linux/futex.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <climits>
#include <ctime>

namespace sluice {
namespace {

long futex(std::atomic<std::uint32_t>& word, int operation, std::uint32_t value, timespec const* time)
{
    return ::syscall(SYS_futex, reinterpret_cast<std::uint32_t*>(&word), operation, value, time, nullptr, 0);
}

}  // namespace

void Bell::sleep(std::chrono::nanoseconds time)
{
    constexpr std::int64_t second = 1'000'000'000;
    timespec const limit{time.count() / second, time.count() % second};
    futex(rest, FUTEX_WAIT, on_bell, &limit);  // shared between processes, so not FUTEX_PRIVATE
    stay_awake();
}

bool Bell::wake()
{
    auto const how = rest.exchange(awake, std::memory_order_seq_cst);
    if (how == on_network) return true;
    if (how != awake) futex(rest, FUTEX_WAKE, INT_MAX, nullptr);
    return false;
}

}  // namespace sluice
