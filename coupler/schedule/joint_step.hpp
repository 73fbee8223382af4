#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "coupler/schedule/acceleration.hpp"

namespace sluice {

//! What one block tells the group about one joint column. Squares in the column's unit squared.
struct ColumnSummary
{
    double used = 0;      //!< |x|^2
    double result = 0;    //!< |x~|^2
    double residual = 0;  //!< |r|^2
    double change = 0;    //!< <r - r_last, r - r_last>, 0 in the first iteration of a window
    double overlap = 0;   //!< <r_last, r - r_last>
    //! Upper trapezoidal R of [V | r], rows i of length differences + 1 - i one after the other; whole rows only.
    std::vector<double> factor;
};

//! What one block tells the group after an iteration.
struct Summary
{
    int method = 0;
    int block = 0;
    int iteration = 0;    //!< of the window, from 0
    int differences = 0;  //!< columns of V
    std::vector<ColumnSummary> columns;
};

//! IQN-ILS keeps at most this many differences (preCICE's advice for large interfaces).
inline constexpr std::size_t most_differences = 100;

std::vector<double> pack(Summary const& summary);
//! Throws Error (protocol) unless the numbers are summaries of one iteration of this group, blocks in ascending order.
std::vector<Summary> unpack(AccelerationConfig const& config, std::span<std::vector<double> const> packed);

//! The step every member takes. Plain loops in one fixed order, so that it has the same bits in every process, whatever
//! instruction set that was compiled for. `last_relaxation`: the factor of the last Aitken step.
AccelerationStep joint_step(AccelerationConfig const& config, std::vector<Summary> const& blocks,
                            double last_relaxation);

}  // namespace sluice
