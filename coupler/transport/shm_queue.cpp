#include "coupler/transport/shm_queue.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <new>
#include <random>

#include "coupler/base/error.hpp"
#include "coupler/transport/buffer.hpp"

namespace sluice {
namespace {

struct Control  //!< the start of the file
{
    Token token;
    Ring ring;
};

constexpr std::size_t granule = 64 * 1024;  // bytes: a multiple of every page size in use
constexpr std::size_t control_size = granule;
constexpr std::size_t file_size = control_size + Ring::slots * ShmOutbox::largest_message;  // sparse
constexpr int most_held = Ring::slots / 2;  // more are copied: who keeps messages does not stop the sender
static_assert(sizeof(Control) <= control_size);

constexpr std::size_t offset_of(int slot)
{
    return control_size + static_cast<std::size_t>(slot) * ShmOutbox::largest_message;
}

//! How much of a slot is backed for a message of `size`: a quarter more, so that growing messages move seldom. Never
//! more on the receiving side than on the sending one, whose slots keep the largest they ever had.
constexpr std::size_t backed(std::size_t size)
{
    auto const wanted = (size + size / 4 + granule) / granule * granule;
    return std::min(wanted, ShmOutbox::largest_message);
}

Control& control_in(Mapping const& mapping)
{
    return *std::launder(reinterpret_cast<Control*>(mapping.data()));
}

}  // namespace

Token random_token()
{
    std::random_device random;
    Token token;
    for (auto& word : token) word = random() | std::uint64_t{random()} << 32;
    return token;
}

ShmOutbox::ShmOutbox()
    : token_(random_token()),
      file_(SharedFile::create(file_size)),
      control_((file_.allocate(0, control_size), file_.map(0, control_size, SharedFile::Access::write))),
      ring_(control_in(control_).ring)
{
    control_in(control_).token = token_;
}

std::span<std::byte> ShmOutbox::reserve(std::size_t size)
{
    require(size <= largest_message, [&] {
        return Error(
            "a message of " + std::to_string(size) + " bytes (at most 1 GiB). Use more participants' processes.",
            Exit::io);
    });
    if (reserved_ < 0) {
        auto const slot = ring_.take();
        if (!slot) return {};
        reserved_ = *slot;
    }
    auto& memory = slots_[static_cast<std::size_t>(reserved_)];
    if (memory.size() < std::max<std::size_t>(size, 1)) {
        auto const capacity = backed(size);
        file_.allocate(offset_of(reserved_), capacity);
        memory = file_.map(offset_of(reserved_), capacity, SharedFile::Access::write);
    }
    return {memory.data(), size};
}

void ShmOutbox::commit(std::size_t size)
{
    ring_.publish(reserved_, size);
    reserved_ = -1;
}

//! A message's hold on its slot.
struct ShmInbox::Held
{
    Held(std::shared_ptr<ShmInbox> inbox, int slot) : inbox(std::move(inbox)), slot(slot) {}
    Held(Held const&) = delete;
    Held& operator=(Held const&) = delete;
    ~Held() { inbox->give_back(slot); }

    std::shared_ptr<ShmInbox> inbox;
    int slot;
};

std::shared_ptr<ShmInbox> ShmInbox::open(SharedFile::Address address, Token const& token)
{
    auto file = SharedFile::open(address, file_size);
    if (!file) return nullptr;
    auto control = file->map(0, control_size, SharedFile::Access::write);
    if (control_in(control).token != token) return nullptr;
    return std::make_shared<ShmInbox>(Key{}, token, std::move(*file), std::move(control));
}

ShmInbox::ShmInbox(Key, Token const& token, SharedFile file, Mapping control)
    : token_(token), file_(std::move(file)), control_(std::move(control)), ring_(control_in(control_).ring)
{}

std::optional<Message> ShmInbox::take()
{
    auto const next = ring_.take();
    if (!next) return std::nullopt;
    auto const held_now = held_.load(std::memory_order_acquire);
    bool const sound = next->slot < Ring::slots && next->size <= ShmOutbox::largest_message &&
                       (held_now & RingSender::bit(static_cast<int>(next->slot))) == 0;
    require(sound, [&] {
        return Error("shared memory: a message of " + std::to_string(next->size) + " bytes in slot " +
                         std::to_string(next->slot) + " (of " + std::to_string(Ring::slots) +
                         ", each once and up to 1 GiB). Its sender is broken.",
                     Exit::protocol);
    });
    int const slot = static_cast<int>(next->slot);
    auto& memory = slots_[next->slot];
    if (memory.size() < std::max<std::uint64_t>(next->size, 1))
        memory = file_.map(offset_of(slot), backed(next->size), SharedFile::Access::read);
    held_.fetch_or(RingSender::bit(slot), std::memory_order_relaxed);
    return std::popcount(held_now) < most_held ? held(slot, next->size) : copied(slot, next->size);
}

Message ShmInbox::held(int slot, std::size_t size)
{
    std::span<std::byte const> const bytes(slots_[static_cast<std::size_t>(slot)].data(), size);
    return {bytes, std::make_shared<Held>(shared_from_this(), slot)};
}

Message ShmInbox::copied(int slot, std::size_t size)
{
    auto copy = std::make_shared<Buffer>();
    auto const room = copy->room(size);
    if (size > 0) std::memcpy(room.data(), slots_[static_cast<std::size_t>(slot)].data(), size);
    give_back(slot);
    return {room, std::move(copy)};
}

void ShmInbox::give_back(int slot)
{
    held_.fetch_and(~RingSender::bit(slot), std::memory_order_release);
    ring_.give_back(slot);
}

}  // namespace sluice
