#pragma once

#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <type_traits>

#include "coupler/transport/shm_queue.hpp"

namespace sluice {

//! What two shared-memory transports tell each other over the network transport.
struct Note
{
    enum class Kind : std::uint32_t
    {
        offer = 1,   //!< here is a queue for messages from me to you, and the bell that wakes me
        accept = 2,  //!< the queue of this token is open here
        moved = 3,   //!< my last message on the network: the next ones are in the queue of this token
        ring = 4,    //!< wake up and look at your queues
    };
    Kind kind = Kind::ring;
    std::int32_t process = 0;
    std::int32_t queue = -1;  //!< descriptors in that process
    std::int32_t bell = -1;
    std::uint64_t life = 0;  //!< of the transport that offers: a process that was started again has another one
    Token token{};           //!< of the queue
    Token bell_token{};
};

//! Every message on the network ends with a trailer: whether it is the user's, or a note.
struct Trailer
{
    static constexpr std::uint32_t mark = 0x4d48'5331;
    enum class Content : std::uint32_t
    {
        user = 1,
        note = 2
    };

    std::uint32_t magic = mark;
    Content content = Content::user;
};
static_assert(std::is_trivially_copyable_v<Note> && std::has_unique_object_representations_v<Note>);
static_assert(std::is_trivially_copyable_v<Trailer> && sizeof(Trailer) == 8);

template <class T>
void put(std::byte* to, T const& value)
{
    static_assert(std::is_trivially_copyable_v<T>);
    std::memcpy(to, &value, sizeof value);
}

//! The trailer of a message; nothing: it has none.
inline std::optional<Trailer> trailer_of(std::span<std::byte const> bytes)
{
    Trailer trailer;
    if (bytes.size() < sizeof trailer) return std::nullopt;
    std::memcpy(&trailer, bytes.last(sizeof trailer).data(), sizeof trailer);
    if (trailer.magic != Trailer::mark) return std::nullopt;
    return trailer;
}

//! `bytes` without the trailer; nothing: that is no note.
inline std::optional<Note> note_in(std::span<std::byte const> bytes)
{
    Note note;
    if (bytes.size() != sizeof note) return std::nullopt;
    std::memcpy(&note, bytes.data(), sizeof note);
    return note;
}

}  // namespace sluice
