#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>

namespace sluice {

//! The word by which a sleeping receiver is woken; it lies in shared memory, one for each receiver.
//!
//! No wake-up is lost. The receiver stores "asleep" and then looks at its queues once more; a sender stores its message
//! and then looks at this word. All four are seq_cst, so they have one order: either the receiver's look comes after
//! the sender's store and finds the message, or the sender's look comes after the receiver's store and it rings. A ring
//! between that look and the sleep changes the word, and the futex does not sleep on a word that has changed.
struct Bell
{
    enum Rest : std::uint32_t
    {
        awake = 0,
        on_bell = 1,     //!< sleeps here
        on_network = 2,  //!< sleeps in the network transport: wake it by a message there
    };

    std::atomic<std::uint32_t> rest;

    //! Receiver: about to sleep. Look at the queues after this, then sleep() or stay_awake().
    void announce(Rest how) { rest.store(how, std::memory_order_seq_cst); }
    void stay_awake() { rest.store(awake, std::memory_order_relaxed); }
    //! Receiver: until somebody rings, or for `time`; may end early. Only after announce(on_bell).
    void sleep(std::chrono::nanoseconds time);
    //! Sender, after its message is there: wakes a receiver that sleeps here. True: wake it through the network.
    [[nodiscard]] bool ring_is_for_network()
    {
        if (rest.load(std::memory_order_seq_cst) == awake) return false;
        return wake();
    }

 private:
    bool wake();
};
static_assert(sizeof(Bell) == 4, "a futex is 32 bits");

}  // namespace sluice
