#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace sluice {

//! Moves opaque messages between participants, numbered as in the scene. Messages of one sender arrive whole and in
//! order, or not at all. One thread uses a transport at a time.
class Transport
{
 public:
    struct Incoming
    {
        int peer = 0;
        std::vector<std::byte> bytes;
    };

    Transport() = default;
    Transport(Transport const&) = delete;
    Transport& operator=(Transport const&) = delete;
    virtual ~Transport() = default;

    //! Hands a message over; the bytes may be reused at once. False: no room now (or no connection yet), try again.
    virtual bool try_send(int peer, std::span<std::byte const> bytes) = 0;
    //! The next message from anybody, or nothing after `patience`.
    virtual std::optional<Incoming> receive(std::chrono::milliseconds patience) = 0;
    //! Whether the connection to a peer that had one is gone: it ended, or it is silent for too long.
    virtual bool lost(int peer) const = 0;
    //! Everybody has met: from now on a connection that breaks is lost for good.
    virtual void settle() {}
    //! Ends this process's part in a way that its peers notice; only after an error.
    virtual void give_up(int /*exit_code*/) {}
};

//! Who is who: what a transport must know to connect `self` with the others.
struct Members
{
    std::vector<std::string> names;  //!< as in the scene
    int self = 0;
};

//! ZeroMQ, one PAIR socket for each peer. `address`: a directory of ours for ipc sockets, or tcp://127.0.0.1:PORT,
//! where each pair has port PORT + lower index * members + higher index. `silence`: how long a peer may be silent
//! before it counts as lost. Two processes must not have the same name in one directory: see NameLock. Throws Error
//! (exit 7) if a port or path cannot be bound.
std::unique_ptr<Transport> make_zmq_transport(Members const& members, std::string const& address,
                                              std::chrono::milliseconds silence);

//! MPI: every participant is one rank of one mpirun, in any order. Initialises MPI, finalises it on destruction.
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
