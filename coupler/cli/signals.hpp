#pragma once

#include <signal.h>

namespace sluice {

//! What the user asks of a running `sluice` by signals: SIGINT and SIGTERM to stop, SIGUSR1 for a checkpoint. While an
//! object lives they are noted instead of ending the process, from before anything is started until all results are
//! written; while nobody listens, a second signal to stop ends it after all. One at a time.
class UserSignals
{
 public:
    UserSignals();
    UserSignals(UserSignals const&) = delete;
    UserSignals& operator=(UserSignals const&) = delete;
    ~UserSignals();

    int take_stop();         //!< the number of a signal to stop since the last call; 0: none
    bool take_checkpoint();  //!< whether one was asked for since the last call

    //! While it lives, somebody takes what is noted.
    struct Listening
    {
        Listening();
        Listening(Listening const&) = delete;
        Listening& operator=(Listening const&) = delete;
        ~Listening();
    };

 private:
    struct sigaction interrupt_ = {}, terminate_ = {}, user_ = {};
};

}  // namespace sluice
