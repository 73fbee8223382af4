#pragma once

#include <atomic>
#include <mutex>
#include <thread>
#include <vector>

#include "coupler/transport/zmq_connection.hpp"
#include "coupler/transport/zmq_doorman.hpp"
#include "coupler/transport/zmq_endpoint.hpp"
#include "coupler/transport/zmq_handle.hpp"

namespace sluice {

//! Watches the connections and answers who may come, in a thread of its own: libzmq stops for everybody when its events
//! are not read, and lets nobody in while nobody answers. One reader takes the events of all sockets.
class ConnectionWatch
{
 public:
    //! `sockets` (null for this member) and `doorman` outlive the watch, which must be there before anything is bound.
    ConnectionWatch(void* context, std::vector<Socket> const& sockets, std::vector<Endpoint> const& endpoints, int self,
                    Doorman const& doorman, std::chrono::milliseconds silence);
    ConnectionWatch(ConnectionWatch const&) = delete;
    ConnectionWatch& operator=(ConnectionWatch const&) = delete;
    ~ConnectionWatch();

    bool lost(int peer) const;
    bool is_taken(int peer) const;  //!< the peer has a connection, which has not ended
    std::string trouble(int peer) const;
    void carried_message(int peer, int descriptor);
    bool take_failed_attempt(int peer);
    //! From now on nobody is let in, and the kernel drops what comes to listening tcp ports.
    void settle();

 private:
    void run();
    void read_event();
    void answer_request();
    Connection* find(std::string const& uri);
    Connection& at(int peer) { return connections_[static_cast<std::size_t>(peer)]; }

    std::vector<Socket> const& sockets_;
    std::vector<Endpoint> const& endpoints_;
    Doorman const& doorman_;
    std::chrono::milliseconds look_every_;
    mutable std::mutex mutex_;
    std::vector<Connection> connections_;  //!< per member, under the mutex
    Socket events_, requests_;             //!< the thread's own
    int stop_ = -1;                        //!< an eventfd
    std::thread thread_;
};

}  // namespace sluice
