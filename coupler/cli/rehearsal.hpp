#pragma once

#include <string>
#include <vector>

#include "coupler/scene/scene.hpp"

namespace sluice {

//! What came of playing a few windows through without solvers: every participant is the schedule that it has in a run
//! (coupler/schedule), takes one unit of time for a computation and none for a message.
struct Rehearsal
{
    std::vector<std::string> waits;  //!< deadlock: who waits for which frame of whom; empty if all windows were played
    std::vector<std::string> critical;  //!< who computes one after the other in one window, once the scheme has settled
    double units_per_window = 0;        //!< how many computations follow each other in a window; 1: all at once
    std::vector<std::string> unread;    //!< participants with partners whose results nobody reads
    std::vector<std::string> leading;   //!< participants that are read and read nobody: they run ahead
    std::vector<std::string> alone;     //!< participants without any coupling, beside others
};

Rehearsal rehearse(Scene const& scene);

}  // namespace sluice
