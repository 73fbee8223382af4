#pragma once

#include <stdexcept>
#include <string>
#include <utility>

namespace sluice {

//! Exit codes of every executable, documented in the README.
enum class Exit : int
{
    ok = 0,
    config = 2,     //!< usage, or a scene with errors
    peer_died = 3,  //!< another participant ended before the run did
    timeout = 4,    //!< a peer is alive but silent, or never came
    protocol = 5,   //!< versions, scenes or frames of two participants do not match
    numerical = 6,  //!< a number that is not finite, a run that blew up
    io = 7,         //!< disk full, file not readable, package missing
    security = 8,   //!< refused for safety
    internal = 70,  //!< a bug of ours
    stopped = 75,   //!< stopped as asked, with a checkpoint: the run can be resumed
    interrupted = 130,
};

//! The only exception type. What the world did wrong: scene, peer, file, physics. A bug is an `assert`.
//! Message grammar: `where: what was seen (what is needed). What to try.`
class Error : public std::runtime_error
{
 public:
    explicit Error(std::string const& message, Exit exit = Exit::config) : std::runtime_error(message), exit_(exit) {}
    Exit exit() const noexcept { return exit_; }

 private:
    Exit exit_;
};

//! Throws the Error that `make_error()` returns unless `ok`; the message costs nothing until it is needed.
template <class MakeError>
void require(bool ok, MakeError&& make_error)
{
    if (!ok) [[unlikely]]
        throw std::forward<MakeError>(make_error)();
}

}  // namespace sluice
