#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "coupler/base/status_page.hpp"

namespace sluice {

//! Watches whether windows still end, from the status pages alone: a solver that computes for ever looks healthy to its
//! peers. A window is slow when it takes 10 times the median of its process's windows and 30 s.
class Watchdog
{
 public:
    using Clock = std::chrono::steady_clock;
    static constexpr double factor = 10, least = 30;  //!< s

    //! `limit`: how long a window may take [s] before the run is to end (timeouts.window); 0: any time.
    Watchdog(std::vector<std::string> names, double limit);

    struct Finding
    {
        std::string text;    //!< who computes what since when, who waits
        bool fatal = false;  //!< beyond the limit
    };
    //! `pages`: one per name. A slow window is found once.
    std::optional<Finding> look(std::vector<MappedStatus> const& pages, Clock::time_point now);

 private:
    struct Seen
    {
        std::int64_t window = -1;
        Clock::time_point since{};
        std::deque<double> lengths = {};  //!< of the last windows [s]
        std::int64_t waited = 0;          //!< ns
        Clock::time_point waited_at{};    //!< when that last grew
        bool warned = false;
    };
    void follow(Seen& seen, MappedStatus const& page, Clock::time_point now) const;
    std::string who_does_what(std::vector<MappedStatus> const& pages, Clock::time_point now) const;

    std::vector<std::string> names_;
    double limit_;
    std::vector<Seen> seen_;
};

}  // namespace sluice
