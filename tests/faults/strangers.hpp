#pragma once

#include <doctest/doctest.h>
#include <zmq.h>

#include <algorithm>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "coupler/transport/keys.hpp"
#include "tests/support/scratch.hpp"
#include "tests/support/tcp_proxy.hpp"

//! Those who are none of a run, and what they throw at its ports.
namespace strangers {

//! A ZeroMQ socket of somebody else's that connects to a listener, with or without security of its own.
class Stranger
{
 public:
    explicit Stranger(
        int port, std::function<void(void*)> const& options = [](void*) {}, int type = ZMQ_PAIR)
        : context_(zmq_ctx_new()), socket_(zmq_socket(context_, type))
    {
        int const zero = 0;
        zmq_setsockopt(socket_, ZMQ_LINGER, &zero, sizeof zero);
        options(socket_);
        zmq_connect(socket_, ("tcp://127.0.0.1:" + std::to_string(port)).c_str());
    }
    Stranger(Stranger const&) = delete;
    Stranger& operator=(Stranger const&) = delete;
    ~Stranger()
    {
        zmq_close(socket_);
        zmq_ctx_term(context_);
    }
    void send(std::string const& text) const { zmq_send(socket_, text.data(), text.size(), ZMQ_DONTWAIT); }
    bool hears_anything() const
    {
        char byte = 0;
        return zmq_recv(socket_, &byte, 1, ZMQ_DONTWAIT) >= 0;
    }

 private:
    void* context_;
    void* socket_;
};

//! Listens in a member's place, lets everybody in and speaks to them.
class Thief
{
 public:
    explicit Thief(int port)
        : context_(zmq_ctx_new()), requests_(zmq_socket(context_, ZMQ_REP)), socket_(zmq_socket(context_, ZMQ_PAIR))
    {
        int const zero = 0, one = 1;
        zmq_bind(requests_, "inproc://zeromq.zap.01");
        zmq_setsockopt(socket_, ZMQ_LINGER, &zero, sizeof zero);
        zmq_setsockopt(socket_, ZMQ_PLAIN_SERVER, &one, sizeof one);
        zmq_setsockopt(socket_, ZMQ_ZAP_DOMAIN, "x", 1);
        REQUIRE(zmq_bind(socket_, ("tcp://127.0.0.1:" + std::to_string(port)).c_str()) == 0);
    }
    Thief(Thief const&) = delete;
    Thief& operator=(Thief const&) = delete;
    ~Thief()
    {
        zmq_close(socket_);
        zmq_close(requests_);
        zmq_ctx_term(context_);
    }
    void welcome_everybody()
    {
        char part[300];
        if (zmq_recv(requests_, part, sizeof part, ZMQ_DONTWAIT) >= 0) {
            ++guests;
            int more = 1;
            for (std::size_t size = sizeof more; more != 0; zmq_getsockopt(requests_, ZMQ_RCVMORE, &more, &size))
                zmq_recv(requests_, part, sizeof part, ZMQ_DONTWAIT);
            for (std::string const word : {"1.0", "1", "200", "", ""})
                zmq_send(requests_, word.data(), word.size(), ZMQ_SNDMORE);
            zmq_send(requests_, "", 0, 0);
        }
        zmq_send(socket_, "I am a", 6, ZMQ_DONTWAIT);
    }
    int guests = 0;

 private:
    void* context_;
    void* requests_;
    void* socket_;
};

inline std::function<void(void*)> plain(std::string const& name, std::string const& word)
{
    return [=](void* s) {
        zmq_setsockopt(s, ZMQ_PLAIN_USERNAME, name.data(), name.size());
        zmq_setsockopt(s, ZMQ_PLAIN_PASSWORD, word.data(), word.size());
    };
}

inline std::function<void(void*)> curve(std::string const& server, sluice::KeyPair const& own)
{
    return [=](void* s) {
        zmq_setsockopt(s, ZMQ_CURVE_SERVERKEY, server.data(), 40);
        zmq_setsockopt(s, ZMQ_CURVE_PUBLICKEY, own.open.data(), 40);
        zmq_setsockopt(s, ZMQ_CURVE_SECRETKEY, own.secret.data(), 40);
    };
}

//! A directory with keys for "a" and "b", and for "stranger", who is none of the run.
struct Keys
{
    Keys()
    {
        for (char const* name : {"a", "b", "stranger"}) sluice::make_key_pair(scratch.path(), name);
    }
    std::string open(char const* name) const { return sluice::read_public_key(scratch.path(), name); }
    sluice::KeyPair pair(char const* name) const { return sluice::read_key_pair(scratch.path(), name); }
    in_threads::Scratch scratch;
};

inline std::string noise(std::mt19937& random, std::size_t size)
{
    std::string bytes(size, '\0');
    std::generate(bytes.begin(), bytes.end(), [&] { return static_cast<char>(random()); });
    return bytes;
}

//! A greeting of ZMTP 3.1 (rfc.zeromq.org/spec/37) for a mechanism, as a client sends it.
inline std::string greeting(std::string mechanism)
{
    std::string text("\xff\0\0\0\0\0\0\0\1\x7f\3\1", 12);
    mechanism.resize(20);
    return text + mechanism + std::string(32, '\0');
}

//! False: nobody accepts there.
inline bool throw_at(int port, std::string const& bytes)
{
    int const s = tcp::connect("127.0.0.1", port);
    if (s < 0) return false;
    (void)!::send(s, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    ::close(s);
    return true;
}

//! So many connections at once, that need not come to anything: each sends its bytes where it is let in. How many were.
inline int throw_many(int port, std::vector<std::string> const& all)
{
    auto const to = tcp::address("127.0.0.1", port);
    std::vector<int> sockets;
    for (std::size_t n = 0; n < all.size(); ++n) {
        sockets.push_back(::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
        (void)!::connect(sockets.back(), reinterpret_cast<sockaddr const*>(&to), sizeof to);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    int taken = 0;
    for (std::size_t n = 0; n < all.size(); ++n) {
        taken += ::send(sockets[n], all[n].data(), all[n].size(), MSG_NOSIGNAL | MSG_DONTWAIT) >= 0;
        ::close(sockets[n]);
    }
    return taken;
}

}  // namespace strangers
