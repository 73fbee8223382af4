#pragma once

#include <atomic>
#include <memory>
#include <vector>

#include "coupler/transport/buffer.hpp"

namespace sluice {

//! Buffers that ZeroMQ sends from in place: one is free again when its I/O thread has let go of it.
class SendPool
{
 public:
    struct Slot
    {
        Buffer buffer;
        std::atomic<bool> busy{false};  //!< cleared by ZeroMQ's thread
    };

    //! A free one, or a new one; how many there are is bounded by what may be queued.
    Slot* take()
    {
        for (auto const& slot : slots_)
            if (!slot->busy.exchange(true, std::memory_order_acquire)) return slot.get();
        slots_.push_back(std::make_unique<Slot>());
        slots_.back()->busy = true;
        return slots_.back().get();
    }

    //! For zmq_msg_init_data: `hint` is the slot.
    static void give_back(void* /*data*/, void* hint)
    {
        static_cast<Slot*>(hint)->busy.store(false, std::memory_order_release);
    }

 private:
    std::vector<std::unique_ptr<Slot>> slots_;
};

}  // namespace sluice
