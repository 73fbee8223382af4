#pragma once

#include <string>

#include "coupler/cli/crew.hpp"

namespace sluice {

//! on-death: restart. Starts again what died, from the newest checkpoint; the others go back by themselves.
class Restarts
{
 public:
    static constexpr int in_a_row = 3;  //!< so many without a new checkpoint in between, then the run ends

    //! Something failed. True: it is dealt with, look again later. False: the run has to end; why_not() tells why, if
    //! it was the scene's wish to go on.
    bool deal_with(Crew& crew);
    std::string const& why_not() const { return why_not_; }
    int total() const { return total_; }

 private:
    bool refuse(std::string const& why);
    bool may_restart(Crew& crew, Job& job);
    bool has_ended(Crew& crew, Job& job);
    void restart(Crew& crew, Job& job, std::size_t number);

    std::string why_not_;
    int total_ = 0, without_progress_ = 0;
    std::int64_t checkpoint_ = -1;  //!< window of the one that was gone back to last
    std::optional<std::chrono::steady_clock::time_point> seen_ = {};
};

}  // namespace sluice
