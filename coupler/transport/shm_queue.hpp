#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <span>

#include "coupler/transport/shm_file.hpp"
#include "coupler/transport/shm_ring.hpp"
#include "coupler/transport/transport.hpp"

namespace sluice {

//! 128 random bits: whoever finds them in a file has found the file that was meant.
using Token = std::array<std::uint64_t, 2>;
Token random_token();

//! The sending end of a queue of messages in a shared file of its own: a Ring, then a slot for each message under way,
//! backed by memory as far as messages have filled it.
class ShmOutbox
{
 public:
    static constexpr std::size_t largest_message = std::size_t{1} << 30;  // bytes

    //! Throws Error (exit 7) without memory.
    ShmOutbox();
    Token const& token() const { return token_; }
    SharedFile::Address address() const { return file_.address(); }

    //! Memory for a message, aligned to a page; empty: all slots are away. Throws Error (exit 7): too large, no memory.
    std::span<std::byte> reserve(std::size_t size);
    //! Sends what was reserved last.
    void commit(std::size_t size);

 private:
    Token token_;
    SharedFile file_;
    Mapping control_;
    RingSender ring_;
    std::array<Mapping, Ring::slots> slots_;
    int reserved_ = -1;
};

//! The receiving end. Messages point into its slots, and keep it alive.
class ShmInbox : public std::enable_shared_from_this<ShmInbox>
{
    struct Key  //!< only open() makes one
    {};

 public:
    //! Nothing: `address` does not lead to the file with this token.
    static std::shared_ptr<ShmInbox> open(SharedFile::Address address, Token const& token);
    ShmInbox(Key, Token const& token, SharedFile file, Mapping control);

    Token const& token() const { return token_; }
    bool ready() const { return ring_.ready(); }
    //! The next message, or nothing. Throws Error (exit 5) if the sender's file makes no sense.
    std::optional<Message> take();

 private:
    struct Held;
    Message held(int slot, std::size_t size);
    Message copied(int slot, std::size_t size);
    void give_back(int slot);

    Token token_;
    SharedFile file_;
    Mapping control_;
    RingReceiver ring_;
    std::array<Mapping, Ring::slots> slots_;
    std::atomic<std::uint32_t> held_{0};  //!< bit s: slot s is with a message
};

}  // namespace sluice
