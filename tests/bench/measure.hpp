#pragma once

#include <array>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/bench/way.hpp"

namespace bench {

struct Contestant
{
    std::string name;
    std::string against;  //!< name of the raw limit; its own: it is one
    MakeWay make;
};

//! How often, and how long.
struct Effort
{
    struct Size
    {
        std::size_t points;
        int rounds;     //!< in each repetition
        int pause = 0;  //!< us that side 0 computes before each: the other side sleeps by then
    };
    std::array<Size, 5> sizes;
    int repetitions;
    double idle_seconds;

    static Effort full()
    {
        return {{{{10, 2000}, {10, 40, 2000}, {1000, 1000}, {10'000, 300}, {100'000, 40}}}, 5, 3.0};
    }
    static Effort small() { return {{{{10, 100}, {10, 4, 2000}, {1000, 50}, {10'000, 10}, {100'000, 3}}}, 5, 0.3}; }
};

using Ways = std::vector<std::unique_ptr<Way>>;
Ways make_ways(std::vector<Contestant> const& contestants, Setting const& setting);

//! Both sides call these alike, side 0 in one process and side 1 in the other; only side 0's result means anything.
//!
//! Every contestant at every size: {case, metric, value, unit, against, ratio, min, max}; value: the median of the
//! repetitions' medians, ratio: that of their ratios to the raw limit, which was measured right before.
nlohmann::json round_trips(std::vector<Contestant> const& contestants, Ways const& ways, int side,
                           Effort const& effort);
//! What waiting costs: {case, metric, value [s of CPU a minute], ...}; against: the 0.5 s that are allowed.
nlohmann::json idle_wait(Contestant const& contestant, Way& way, Effort const& effort);

//! Runs `body` on both sides, side 1 in a process of its own. Throws std::runtime_error if that one failed.
nlohmann::json in_two_processes(nlohmann::json (*body)(Setting const&, Effort const&), Effort const& effort);
//! This program twice under mpirun, as `--mpi-side FILE`: side 0 writes the results to the file. `windows`: of
//! whole sessions.
nlohmann::json under_mpirun(bool small, bool windows);

}  // namespace bench
