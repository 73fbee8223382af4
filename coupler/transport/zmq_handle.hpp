#pragma once

#include <zmq.h>

#include <cerrno>
#include <memory>
#include <string>

#include "coupler/base/error.hpp"

namespace sluice {

struct CloseSocket
{
    void operator()(void* socket) const
    {
        zmq_socket_monitor(socket, nullptr, 0);  // before who reads its events closes: libzmq would wait for him
        zmq_close(socket);
    }
};
using Socket = std::unique_ptr<void, CloseSocket>;

struct CloseContext
{
    void operator()(void* context) const { zmq_ctx_term(context); }
};
using Context = std::unique_ptr<void, CloseContext>;

//! Throws Error (exit 7) when descriptors are short.
inline Socket new_socket(void* context, int type)
{
    Socket socket(zmq_socket(context, type));
    require(socket != nullptr, [] {
        return Error(std::string("no ZeroMQ socket: ") + zmq_strerror(errno) + ". Raise `ulimit -n`?", Exit::io);
    });
    return socket;
}

inline void set_option(void* socket, int option, int value)
{
    zmq_setsockopt(socket, option, &value, sizeof value);
}

//! Throws Error (exit 70): an option that this libzmq does not take must not be left out in silence.
inline void set_text(void* socket, int option, std::string const& value)
{
    require(zmq_setsockopt(socket, option, value.data(), value.size()) == 0, [] {
        return Error(std::string("libzmq refuses an option: ") + zmq_strerror(errno) + " (needed: one with CURVE).",
                     Exit::internal);
    });
}

//! Keeps a received message alive.
struct Received
{
    Received() { zmq_msg_init(&message); }
    Received(Received const&) = delete;
    Received& operator=(Received const&) = delete;
    ~Received() { zmq_msg_close(&message); }
    zmq_msg_t message;
};

}  // namespace sluice
