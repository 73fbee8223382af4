#pragma once

#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace sluice {

//! What two processes share beside the bytes: which slot holds which message, and which slots have come back. It lies
//! in shared memory, all zero at first; either side may read garbage from a broken peer, so nothing here is trusted.
struct Ring
{
    static constexpr int slots = 32;

    struct alignas(64) Entry  //!< one cache line: the news and what it says travel together
    {
        std::atomic<std::uint64_t> number;  //!< 1 + the message's number, once it is there
        std::uint64_t size;
        std::uint32_t slot;
    };

    alignas(64) std::atomic<std::uint32_t> returned;  //!< bit s: slot s has come back
    std::array<Entry, slots> entries;                 //!< message n in entry n % slots
};
static_assert(std::atomic<std::uint64_t>::is_always_lock_free && std::atomic<std::uint32_t>::is_always_lock_free);
static_assert(Ring::slots == 32 && std::has_single_bit(unsigned{Ring::slots}));

//! The sending end. Entry n % slots is free for message n: messages are taken in order, each holds a slot until it
//! comes back, and the sender has one slot in hand, so message n - slots was taken long ago.
class RingSender
{
 public:
    explicit RingSender(Ring& ring) : ring_(&ring)
    {
        for (int slot = Ring::slots; slot-- > 0;) put_back(slot);
    }

    //! The slot that came back last, which is the likeliest to be in the cache; nothing: all are away.
    std::optional<int> take()
    {
        if (ring_->returned.load(std::memory_order_relaxed) != 0) {
            // acquire: what the receiver read from the slot, it has read before we write there
            auto back = ring_->returned.exchange(0, std::memory_order_acquire) & away_;
            for (; back != 0; back &= back - 1) put_back(std::countr_zero(back));
        }
        if (free_count_ == 0) return std::nullopt;
        int const slot = free_[--free_count_];
        away_ |= bit(slot);
        return slot;
    }

    //! Back unused. A slot is free once at most, whatever a broken peer returns.
    void put_back(int slot)
    {
        if ((away_ & bit(slot)) == 0) return;
        away_ &= ~bit(slot);
        free_[free_count_++] = static_cast<std::uint8_t>(slot);
    }

    //! Sends. The number is stored in the order of all seq_cst operations: see Bell.
    void publish(int slot, std::size_t size)
    {
        auto& entry = ring_->entries[next_ % Ring::slots];
        entry.size = size;
        entry.slot = static_cast<std::uint32_t>(slot);
        entry.number.store(++next_, std::memory_order_seq_cst);
    }

    static constexpr std::uint32_t bit(int slot) { return std::uint32_t{1} << slot; }

 private:
    Ring* ring_;
    std::uint64_t next_ = 0;
    std::uint32_t away_ = ~0U;  //!< slots that are not in free_
    std::array<std::uint8_t, Ring::slots> free_{};
    unsigned free_count_ = 0;
};

//! The receiving end: one thread takes, any thread gives back.
class RingReceiver
{
 public:
    struct Descriptor  //!< as the sender wrote it: to be checked
    {
        std::uint64_t size;
        std::uint32_t slot;
    };

    explicit RingReceiver(Ring& ring) : ring_(&ring) {}

    //! seq_cst: in the order of all such operations, see Bell.
    bool ready() const { return entry().number.load(std::memory_order_seq_cst) == next_ + 1; }

    std::optional<Descriptor> take()
    {
        auto const& next = entry();
        if (next.number.load(std::memory_order_acquire) != next_ + 1) return std::nullopt;
        ++next_;
        return Descriptor{next.size, next.slot};
    }

    void give_back(int slot) { ring_->returned.fetch_or(RingSender::bit(slot), std::memory_order_release); }

 private:
    Ring::Entry const& entry() const { return ring_->entries[next_ % Ring::slots]; }

    Ring* ring_;
    std::uint64_t next_ = 0;
};

}  // namespace sluice
