#pragma once

#include <array>
#include <cstddef>

namespace mpm {

//! Whether sharing the work is worth it. Where others use the cores a thread is stopped with a piece in hand, for
//! milliseconds, and all wait: one thread alone is faster then. So now and then some steps go alone and some together,
//! long enough for such stops to show, and until the next trial all go as took less.
class Pace
{
 public:
    bool together() const { return phase_ == 0 || (phase_ == 2 && worth_); }

    //! Of a step that went as together() said [s].
    void took(double seconds)
    {
        spent_ += seconds;
        ++steps_;
        if (spent_ < length[phase_]) return;
        if (phase_ < 2) mean_[phase_] = spent_ / steps_;
        if (phase_ == 1) worth_ = mean_[0] < mean_[1];
        phase_ = (phase_ + 1) % 3;
        spent_ = steps_ = 0;
    }

 private:
    static constexpr std::array<double, 3> length{0.03, 0.01, 0.4};  //!< together, alone, as is better [s]

    std::size_t phase_ = 0;
    double spent_ = 0, steps_ = 0;  //!< in this phase
    std::array<double, 2> mean_{};
    bool worth_ = false;
};

}  // namespace mpm
