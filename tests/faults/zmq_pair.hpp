#pragma once

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "coupler/base/error.hpp"
#include "coupler/transport/transport.hpp"
#include "tests/conformance/transport_suite.hpp"
#include "tests/support/ports.hpp"
#include "tests/support/run_in_threads.hpp"
#include "tests/support/tcp_proxy.hpp"

//! Members "a" (0, listens) and "b" (1, connects), driven in turn by one thread, or each in a process of its own.
namespace zmq_pair {

using sluice::Network;
using sluice::Transport;
using std::chrono::milliseconds;
using std::chrono::seconds;
using Owner = std::unique_ptr<Transport>;

constexpr milliseconds silence{1500};
constexpr seconds patience{20};  // of a test with a loaded machine

inline Network over_ipc(in_threads::Scratch const& scratch)
{
    return {.directory = scratch.path(), .silence = silence};
}

inline Network over_loopback(in_threads::Scratch const& scratch, int port)
{
    return {.directory = scratch.path(), .address = "tcp://127.0.0.1:" + std::to_string(port), .silence = silence};
}

inline Network with_hosts(int port, std::filesystem::path const& keys = {})
{
    return {.hosts = {"127.0.0.1", "127.0.0.1"}, .port = port, .keys = keys, .silence = silence};
}

inline int port_of_pair(int port)
{
    return port + 1;
}  //!< PORT + low * n + high

inline Owner member(int self, Network const& network)
{
    return sluice::make_zmq_transport({{"a", "b"}, self}, network);
}

//! Both members, b's way to a through a proxy.
struct Apart
{
    static Network seen_by_b(int port)
    {
        auto network = with_hosts(port);
        network.hosts[0] = "127.0.0.2";
        return network;
    }

    int port = ports::take();
    tcp::Proxy proxy{"127.0.0.2", "127.0.0.1", port_of_pair(port)};
    Owner a = member(0, with_hosts(port)), b = member(1, seen_by_b(port));
};

inline bool within(std::chrono::duration<double> time, std::function<bool()> const& happened)
{
    auto const end = std::chrono::steady_clock::now() + time;
    while (!happened())
        if (std::chrono::steady_clock::now() > end) return false;
    return true;
}

//! The next message's text, or "" after 20 s.
inline std::string text_from(Transport& t)
{
    std::string text;
    within(patience, [&] {
        auto const incoming = t.receive(milliseconds(10));
        if (incoming)
            text.assign(reinterpret_cast<char const*>(incoming->message.bytes.data()), incoming->message.bytes.size());
        return incoming.has_value();
    });
    return text;
}

inline bool say(Transport& t, int peer, std::string const& text)
{
    return within(patience, [&] {
        bool const sent = t.try_send(peer, std::as_bytes(std::span(text)));
        if (!sent) std::this_thread::sleep_for(milliseconds(1));
        return sent;
    });
}

//! Both sides connect: a message each way, then everybody has met.
inline bool greet(Transport& a, Transport& b)
{
    bool said_a = false, said_b = false;
    bool const met = within(patience, [&] {
        said_a = said_a || a.try_send(1, std::as_bytes(std::span("from a", 6)));
        said_b = said_b || b.try_send(0, std::as_bytes(std::span("from b", 6)));
        if (!said_a || !said_b) std::this_thread::sleep_for(milliseconds(1));
        return said_a && said_b;
    });
    return met && text_from(a) == "from b" && text_from(b) == "from a";
}

inline bool meet(Transport& a, Transport& b)
{
    bool const met = greet(a, b);
    a.settle();
    b.settle();
    return met;
}

//! `count` numbered messages each way, in turn.
inline bool talk(Transport& a, Transport& b, int count)
{
    for (int n = 0; n < count; ++n) {
        auto const text = "message " + std::to_string(n);
        if (!say(a, 1, text) || text_from(b) != text || !say(b, 0, text) || text_from(a) != text) return false;
    }
    return true;
}

inline bool finds_lost(Transport& t, int peer)
{
    return within(patience, [&] {
        (void)t.receive(milliseconds(10));
        return t.lost(peer);
    });
}

//! `body` in a process of its own, which never returns from it; ended with the object. Make it before any transport.
class Child
{
 public:
    explicit Child(std::function<void()> const& body) : pid_(::fork())
    {
        if (pid_ != 0) return;
        try {
            body();
            ::_exit(0);
        } catch (std::exception const& e) {
            std::fprintf(stderr, "child: %s\n", e.what());
            ::_exit(1);
        }
    }
    Child(Child const&) = delete;
    Child& operator=(Child const&) = delete;
    ~Child() { end(SIGKILL); }
    void signal(int number) const { ::kill(pid_, number); }
    void end(int number)
    {
        if (pid_ <= 0) return;
        ::kill(pid_, number);
        ::waitpid(pid_, nullptr, 0);
        pid_ = 0;
    }
    pid_t pid() const { return pid_; }

 private:
    pid_t pid_;
};

//! Says "from b", hears one message, then echoes whatever comes.
inline void echo(Network const& network)
{
    auto const b = member(1, network);
    say(*b, 0, "from b");
    (void)text_from(*b);
    b->settle();
    for (;;)
        if (auto const incoming = b->receive(milliseconds(100)))
            while (!b->try_send(0, incoming->message.bytes)) std::this_thread::sleep_for(milliseconds(1));
}

inline bool meet_child(Transport& a)
{
    bool const met = say(a, 1, "from a") && text_from(a) == "from b";
    a.settle();
    return met;
}

}  // namespace zmq_pair
