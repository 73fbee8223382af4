#pragma once

#include <nlohmann/json.hpp>

//! Facts of whole runs: participants as processes of their own (coupling_member.cpp), started by hand or by `sluice
//! run`. All: [{case, metric, value, unit, against, ratio, ...}]. Throw std::runtime_error if a run fails.
namespace bench {

//! How often, and how long.
struct RunEffort
{
    int starts = 20;        //!< of which the median is taken
    double wait = 20;       //!< s
    int points = 100'000;   //!< of the cloud whose exchange is hidden
    double compute = 0.01;  //!< s a window, to hide it behind
    int windows = 60;
    int repetitions = 5;

    static RunEffort small()
    {
        return {.starts = 2, .wait = 0.5, .points = 1000, .compute = 1e-3, .windows = 10, .repetitions = 1};
    }
};

//! From before the first process is made until both participants are in their first window.
nlohmann::json start_up(RunEffort const& effort);
//! CPU time of a participant that waits: for one that computes, and for one that has not come yet.
nlohmann::json waiting(RunEffort const& effort);
//! Bytes that a window takes of which a part is not sent: columns that do not change, points out of the edge's region.
nlohmann::json bytes_sent();
//! How much of the exchange of two that compute at once costs no time, since it goes on while they compute.
nlohmann::json overlap(RunEffort const& effort);

}  // namespace bench
