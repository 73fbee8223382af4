#pragma once

#include <sched.h>

#include <algorithm>
#include <chrono>

namespace sluice {

//! How many cores this process may use.
inline int available_cores()
{
    cpu_set_t set;
    CPU_ZERO(&set);
    return ::sched_getaffinity(0, sizeof set, &set) == 0 ? CPU_COUNT(&set) : 1;
}

//! How long a wait spins before it sleeps. Waking a sleeper costs about 50 us, so a wait that will end soon is worth
//! spinning for; a core that somebody else needs is not: a yield that comes back late ends the spin.
class Spin
{
 public:
    using Clock = std::chrono::steady_clock;

    //! `crowded`: there are more processes than cores, so the one waited for may need this very core.
    void set_crowded(bool crowded) { crowded_ = crowded; }

    void begin(Clock::time_point now)
    {
        start_ = looked_ = now;
        budget_ = typical_ < soon ? std::clamp<Clock::duration>(2 * typical_, least, most) : Clock::duration(least);
    }

    //! Between two looks: true after a pause that is worth another look, false: sleep.
    bool again(Clock::time_point now)
    {
        auto const spun = now - start_;
        if (waited_ + spun >= budget_) return false;
        if (!crowded_ && spun < pure) {
            for (int i = 0; i < 4; ++i) pause();
        } else {
            if (now - looked_ > interrupted) return false;
            ::sched_yield();
        }
        looked_ = now;
        return true;
    }

    //! A message was there at once.
    void found()
    {
        waited_ = {};
        typical_ -= typical_ / 4;
    }
    //! A message came.
    void found(Clock::time_point now)
    {
        typical_ += (std::min<Clock::duration>(waited_ + (now - start_), 2 * soon) - typical_) / 4;
        waited_ = {};
    }
    //! Nothing came: the next wait is this one's continuation.
    Clock::duration waited() const { return waited_; }  //!< in vain, since the last message
    void gave_up(Clock::time_point now) { waited_ += now - start_; }

 private:
    static constexpr std::chrono::microseconds pure{10};         // without giving way
    static constexpr std::chrono::microseconds least{50};        // as long as a wake-up takes
    static constexpr std::chrono::microseconds soon{500};        // typical waits that are spun for
    static constexpr std::chrono::microseconds most{1000};       // of one wait
    static constexpr std::chrono::microseconds interrupted{20};  // between two looks: somebody else ran

    static void pause()
    {
#if defined(__x86_64__)
        __builtin_ia32_pause();
#elif defined(__aarch64__)
        asm volatile("yield");
#endif
    }

    Clock::time_point start_{}, looked_{};
    Clock::duration budget_{}, typical_{};
    Clock::duration waited_{};
    bool crowded_ = false;
};

}  // namespace sluice
