#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "participants/dem/config.hpp"
#include "participants/dem/solver.hpp"

//! The settled column of spheres that the benchmark of grains measures, and how it is timed.
namespace dem_bench {

inline constexpr double mean_radius = 4e-3;  // m
inline constexpr int warm_up = 100;          // steps before the clock starts

//! What `--json` writes: {case, metric, value, unit, against, ratio}.
inline nlohmann::json results = nlohmann::json::array();

//! A line of it.
void note(std::string const& name, char const* metric, double value, char const* unit, char const* against,
          double ratio);

//! Side of a column about as high as wide [m].
double side_of(std::size_t grains);
//! Spheres of 8 mm +- 10 % that came to rest from a loose lattice, kept for the next run.
dem::Grains<3> settled(std::size_t count);

//! The column's laws as our own scenes have them: dashpots by the damping ratio.
dem::ContactConfig laws(dem::Rolling rolling = dem::Rolling::none);

double processor_time(int who);  //!< of getrusage [s]
double own_time();               //!< of the processor [s]
double wall_time();              //!< s; processor time counts threads that wait

//! Seconds for so many steps.
double run_ours(dem::Solver<3> solver, int steps, double (*clock)());
double median(std::vector<double> values);

//! Prints what each feature of a scene costs, what a contact costs and how near that is to the machine's limits.
void features(std::size_t count, int steps, int repetitions);

//! Prints error and time of oblique impacts (D03) by the step, in our order of things and in LIGGGHTS'.
void impact_errors();
//! Prints run-out and time of a column of 3000 discs (D11) by the step: minutes.
void run_out_errors();

}  // namespace dem_bench
