#pragma once

#include <chrono>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace sluice {

//! A received message. Its bytes stay where they arrived (shared memory, a ZeroMQ message, a buffer of MPI's) as long
//! as somebody holds `owner`; at least 8-byte alignment is not promised.
struct Message
{
    std::span<std::byte const> bytes;
    std::shared_ptr<void const> owner;
};

//! Moves opaque messages between members (processes), numbered alike everywhere. Messages of one sender arrive whole
//! and in order, or not at all. One thread uses a transport at a time.
class Transport
{
 public:
    using Clock = std::chrono::steady_clock;
    struct Incoming
    {
        int peer = 0;
        Message message;
    };

    Transport() = default;
    Transport(Transport const&) = delete;
    Transport& operator=(Transport const&) = delete;
    virtual ~Transport() = default;

    //! Memory for a message of up to `size` bytes to `peer`, aligned to 64 bytes, to be filled and then sent by
    //! commit(). Empty: no room now, take in what has come and try again. A second call before commit() takes the first
    //! one's place.
    virtual std::span<std::byte> reserve(int peer, std::size_t size) = 0;
    //! Sends the first `size` bytes of what reserve() gave. False: not now (or no connection yet); what was written is
    //! kept, call again.
    [[nodiscard]] virtual bool commit(int peer, std::size_t size) = 0;
    //! reserve, copy, commit. False: not sent; the bytes are the caller's to send again.
    [[nodiscard]] bool try_send(int peer, std::span<std::byte const> bytes)
    {
        auto const room = reserve(peer, bytes.size());
        if (room.size() < bytes.size() || room.data() == nullptr) return false;
        if (!bytes.empty()) std::memcpy(room.data(), bytes.data(), bytes.size());
        return commit(peer, bytes.size());
    }

    //! The next message from anybody, or nothing after `patience`. Spins briefly, then sleeps.
    virtual std::optional<Incoming> receive(std::chrono::microseconds patience) = 0;
    //! Whether the connection to a peer that had one is gone: it ended, or it is silent for too long.
    virtual bool lost(int peer) const = 0;
    //! Why a peer is lost or does not come, as far as it is known, e.g. "no heartbeat for 2 s" or "its key is not in
    //! the allow-list"; empty: nothing is known.
    virtual std::string trouble(int /*peer*/) const { return {}; }
    //! Everybody has met: from now on a connection that breaks is lost for good.
    virtual void settle() {}
    //! Ends this process's part in a way that its peers notice; only after an error.
    virtual void give_up(int /*exit_code*/) {}
    //! What messages travel by once everybody has met, for reports: "zmq", "shm", "shm 2, zmq 1".
    virtual std::string kind() const = 0;
    //! The clock that deadlines are kept by; a simulation has its own.
    virtual Clock::time_point now() const { return Clock::now(); }
};

//! Who is who: what a transport must know to connect `self` with the others.
struct Members
{
    std::vector<std::string> names;  //!< "grains", or "water:0", "water:1" where a participant has several processes
    int self = 0;
};

//! Where the members of a run listen, and what protects them. One of `directory` (ipc), `address` (tcp on this host's
//! loopback; with a `directory` only processes that can enter it take part), or `hosts` with `port`.
struct Network
{
    std::filesystem::path directory = {};  //!< of ours, mode 0700, for ipc sockets
    std::string address = {};              //!< tcp://127.0.0.1:PORT: pair (low, high) uses PORT + low * n + high
    std::vector<std::string> hosts = {};   //!< per member the address where it listens; empty: this host's loopback
    int port = 0;                          //!< first port with `hosts`, numbered as with `address`
    std::filesystem::path keys = {};       //!< directory of CURVE keys; empty: no encryption
    std::chrono::milliseconds silence{10'000};           //!< how long a peer may be silent before it counts as lost
    std::size_t largest_message = std::size_t{1} << 30;  //!< bytes; more is refused on both sides, alike everywhere
    int queue = 64;  //!< messages that wait at each end; more than a peer sends ahead of one that computes
};

//! ZeroMQ, one PAIR socket for each peer. Before settle() a peer may be started again: it is then lost() for a moment,
//! and what was sent to it before is gone. Throws Error (exit 2) if a host or port cannot be; (exit 5) if another
//! process listens in this one's place; (exit 7) if a port or path cannot be bound; (exit 8) if keys or directory are
//! not safe.
std::unique_ptr<Transport> make_zmq_transport(Members const& members, Network const& network);

//! Shared memory between members on one host, ZeroMQ between others; hosts need not be told. Handshake and liveness
//! stay with ZeroMQ, so `network` is what make_zmq_transport() takes, and so are the errors. Every member must use it.
std::unique_ptr<Transport> make_shm_transport(Members const& members, Network const& network);

//! Initialises MPI if that has not been done. It waits for every rank with 10 000 looks a second: the earlier all call
//! it, the less.
void start_mpi();

//! MPI: every member is one rank of one mpirun, in any order. Initialises MPI, finalises it on destruction.
std::unique_ptr<Transport> make_mpi_transport(Members const& members);

//! In-process, for tests: transports made from one hub reach each other from different threads.
class LoopbackHub
{
 public:
    explicit LoopbackHub(int members);
    ~LoopbackHub();
    //! `self` leaves when its transport is destroyed: its peers then find it lost.
    std::unique_ptr<Transport> connect(int self);
    struct State;

 private:
    std::shared_ptr<State> state_;
};

}  // namespace sluice
