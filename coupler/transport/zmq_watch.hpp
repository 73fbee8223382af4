#pragma once

#include <atomic>
#include <condition_variable>
#include <deque>
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
    //! `endpoints` and `doorman` outlive the watch, which must be there before anything is bound.
    ConnectionWatch(void* context, std::vector<Endpoint> const& endpoints, int self, Doorman const& doorman,
                    std::chrono::milliseconds silence);
    ConnectionWatch(ConnectionWatch const&) = delete;
    ConnectionWatch& operator=(ConnectionWatch const&) = delete;
    ~ConnectionWatch();

    //! From now on its events are read; before it binds or connects. The watch outlives it.
    void attach(int peer, void* socket);

    bool lost(int peer) const;
    //! There is a connection, and its handshake is over.
    bool is_open(int peer) const { return open_[static_cast<std::size_t>(peer)].load(std::memory_order_relaxed); }
    std::string trouble(int peer) const;
    void carried_message(int peer, int descriptor);
    bool take_failed_attempt(int peer);
    //! From now on nobody is let in, and the kernel drops what comes to listening tcp ports.
    void settle();

 private:
    void run();
    void wake() const;
    void read_event();
    void answer_request();
    Connection* find(std::string const& uri);
    Connection& at(int peer) { return connections_[static_cast<std::size_t>(peer)]; }

    std::vector<Endpoint> const& endpoints_;
    int const self_;
    Doorman const& doorman_;
    std::chrono::milliseconds look_every_;
    mutable std::mutex mutex_;
    std::vector<Connection> connections_;  //!< per member, under the mutex
    std::deque<std::atomic<bool>> open_;   //!< per member
    Socket events_, requests_;             //!< the thread's own
    int wake_ = -1;                        //!< an eventfd
    bool ending_ = false;                  //!< under the mutex
    std::string to_attach_;                //!< under the mutex: address to read events from; empty: done
    std::condition_variable attached_;
    int attachments_ = 0;
    std::thread thread_;
};

}  // namespace sluice
