#pragma once

#include <array>
#include <cstddef>

namespace mpm {

//! Whether sharing the work is worth it. Where others use the cores a thread is stopped with a piece in hand, for
//! milliseconds, and all wait: one thread alone is faster then. So now and then some steps go alone and some together,
//! long enough for such stops to show, and until the next trial all go as took less: for ten times as long, however
//! long a step is, so that trials take less than a tenth.
class Pace
{
 public:
    bool together() const { return phase_ == 0 || (phase_ == 2 && worth_); }

    //! Of a step that went as together() said [s].
    void took(double seconds)
    {
        spent_ += seconds;
        ++steps_;
        if (spent_ < (phase_ == 2 ? 10 * tried_ : length[phase_])) return;
        if (phase_ < 2) mean_[phase_] = spent_ / steps_;
        tried_ = phase_ < 2 ? tried_ + spent_ : 0;
        if (phase_ == 1) worth_ = mean_[0] < mean_[1];
        phase_ = (phase_ + 1) % 3;
        spent_ = steps_ = 0;
    }

 private:
    static constexpr std::array<double, 2> length{0.03, 0.01};  //!< of trials at least: together, alone [s]

    std::size_t phase_ = 0;         //!< together, alone, as is better
    double spent_ = 0, steps_ = 0;  //!< in this phase
    double tried_ = 0;              //!< time of the last two trials [s]
    std::array<double, 2> mean_{};
    bool worth_ = false;
};

}  // namespace mpm
