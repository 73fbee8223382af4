#pragma once

#include <string_view>
#include <vector>

namespace sluice {

//! What an exit code or a family of messages means.
struct Explanation
{
    int code;               //!< exit code; -1: a family of messages
    std::string_view word;  //!< one word to ask by
    std::string_view says;  //!< one line: what it is, or how its messages read
    std::string_view more;  //!< why it happens and what to do
};

//! All of them, exit codes first. `sluice explain`, its completion and the README show what stands here.
std::vector<Explanation> const& explanations();

}  // namespace sluice
