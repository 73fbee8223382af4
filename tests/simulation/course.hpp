#pragma once

#include <optional>

#include "tests/simulation/solver.hpp"

namespace simulation {

//! One course of a run, and what came of it.
struct Course
{
    struct Ending
    {
        bool crashed = false;
        bool well = false;
        int exit = 0;
        std::string error = {};
        Record record = {};
    };
    std::vector<Ending> endings;  //!< per member
    bool ended = false;           //!< everybody, in time
    std::int64_t messages = 0, struck = 0;
    double seconds = 0;  //!< of virtual time
};

Course run_course(Topology const& topology, std::uint64_t seed, Conditions const& conditions, std::int64_t work,
                  Fibers& fibers);

//! The first rule that a course breaks; empty if it keeps all of them. `calm`: the course without faults or delays.
std::string broken_rule(Topology const& topology, Course const& course, Course const& calm);

//! Every schedule from `first` on, `count` of them; stops at the first broken rule.
struct Tally
{
    std::int64_t schedules = 0, faulty = 0, failed = 0;  //!< with faults that struck; in which somebody failed
    std::string broken = {};                             //!< says how to see it again
};
Tally run_schedules(std::int64_t first, std::int64_t count);
std::string describe_schedule(std::int64_t number);  //!< what happens in it, for a person who looks for a mistake

inline constexpr std::int64_t schedules_per_topology = 50;

}  // namespace simulation
