#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "coupler/base/status_page.hpp"

namespace sluice {

//! Shows how far a run is: a bar with time to go on a terminal, a line every 5 s in a log, nothing when quiet.
class Progress
{
 public:
    Progress(std::vector<std::string> names, bool quiet);  //!< of the processes, in the order of their pages
    void show(std::vector<MappedStatus> const& pages);
    void clear();  //!< leaves the terminal's line free for a message

 private:
    std::string line(std::vector<MappedStatus> const& pages);

    std::vector<std::string> names_;
    bool quiet_;
    bool terminal_;
    bool drawn_ = false;
    std::chrono::steady_clock::time_point next_{};
    std::chrono::steady_clock::time_point first_window_{};
    bool running_ = false;
};

}  // namespace sluice
