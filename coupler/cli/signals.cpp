#include "coupler/cli/signals.hpp"

#include <atomic>

namespace sluice {
namespace {

std::atomic<int> stop{0};
std::atomic<bool> checkpoint{false}, listening{false};
static_assert(std::atomic<int>::is_always_lock_free && std::atomic<bool>::is_always_lock_free);

extern "C" void note_signal(int number)
{
    if (number == SIGUSR1) {
        checkpoint = true;
    } else if (stop.exchange(number) != 0 && !listening) {
        ::signal(number, SIG_DFL);
        ::raise(number);  // delivered when this handler returns
    }
}

}  // namespace

UserSignals::UserSignals()
{
    stop = 0;
    checkpoint = false;
    struct sigaction action = {};
    action.sa_handler = note_signal;
    action.sa_flags = SA_RESTART;
    ::sigaction(SIGINT, &action, &interrupt_);
    ::sigaction(SIGTERM, &action, &terminate_);
    ::sigaction(SIGUSR1, &action, &user_);
}

UserSignals::~UserSignals()
{
    ::sigaction(SIGINT, &interrupt_, nullptr);
    ::sigaction(SIGTERM, &terminate_, nullptr);
    ::sigaction(SIGUSR1, &user_, nullptr);
}

UserSignals::Listening::Listening()
{
    listening = true;
}

UserSignals::Listening::~Listening()
{
    listening = false;
}

int UserSignals::take_stop()
{
    return stop.exchange(0);
}

bool UserSignals::take_checkpoint()
{
    return checkpoint.exchange(false);
}

}  // namespace sluice
