#include <stdlib.h>
#include <unistd.h>
#include <zmq.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "coupler/transport/transport.hpp"

//! Round trips of N points of 32 bytes between two threads: the ZeroMQ transport against a raw PAIR of sockets that
//! blocks in zmq_msg_recv. Prints CSV; both are measured in turn, and the fastest of each compared, since other load on
//! the machine only ever adds.

namespace {

using Clock = std::chrono::steady_clock;
constexpr int repeats = 40;

double seconds_since(Clock::time_point begin)
{
    return std::chrono::duration<double>(Clock::now() - begin).count();
}

struct Raw
{
    Raw(std::string const& where, bool listener) : context(zmq_ctx_new()), socket(zmq_socket(context, ZMQ_PAIR))
    {
        if ((listener ? zmq_bind(socket, where.c_str()) : zmq_connect(socket, where.c_str())) != 0)
            std::fprintf(stderr, "%s: %s\n", where.c_str(), zmq_strerror(errno));
    }
    ~Raw()
    {
        zmq_close(socket);
        zmq_ctx_term(context);
    }
    void send(std::vector<char> const& bytes) const { zmq_send(socket, bytes.data(), bytes.size(), 0); }
    void receive() const
    {
        zmq_msg_t message;
        zmq_msg_init(&message);
        zmq_msg_recv(&message, socket, 0);
        zmq_msg_close(&message);
    }
    void* context;
    void* socket;
};

struct Ours
{
    Ours(sluice::Network const& network, int self)
        : transport(sluice::make_zmq_transport({{"a", "b"}, self}, network)), peer(1 - self)
    {}
    void send(std::vector<char> const& bytes) const
    {
        while (!transport->try_send(peer, std::as_bytes(std::span(bytes)))) std::this_thread::yield();
    }
    void receive() const
    {
        while (!transport->receive(std::chrono::milliseconds(100))) {
        }
    }
    std::unique_ptr<sluice::Transport> transport;
    int peer;
};

//! Seconds of one round trip.
template <class Side>
double round_trip(Side const& here, Side const& there, std::size_t size, int count)
{
    std::vector<char> const bytes(size, 'x');
    std::thread echo([&] {
        for (int n = 0; n < count; ++n) {
            there.receive();
            there.send(bytes);
        }
    });
    auto const begin = Clock::now();
    for (int n = 0; n < count; ++n) {
        here.send(bytes);
        here.receive();
    }
    double const time = seconds_since(begin) / count;
    echo.join();
    return time;
}

void compare(char const* kind, std::string const& raw_where, sluice::Network const& network)
{
    Raw const raw_a(raw_where, true), raw_b(raw_where, false);
    Ours const a(network, 0), b(network, 1);
    round_trip(a, b, 10, 100);
    a.transport->settle();
    b.transport->settle();
    for (std::size_t points : {10u, 100u, 1'000u, 10'000u, 100'000u}) {
        int const count = static_cast<int>(std::clamp<std::size_t>(200'000 / (points + 1000), 4, 100));
        double raw = 1e9, ours = 1e9;
        for (int k = 0; k < repeats; ++k) {
            raw = std::min(raw, round_trip(raw_a, raw_b, points * 32, count));
            ours = std::min(ours, round_trip(a, b, points * 32, count));
        }
        std::printf("%s,%zu,%.1f,%.1f,%.2f\n", kind, points, 1e6 * raw, 1e6 * ours, ours / raw);
    }
}

}  // namespace

int main()
{
    char pattern[] = "/tmp/sluice-bench-XXXXXX";
    std::filesystem::path const directory = ::mkdtemp(pattern);
    int const port = 10'000 + ::getpid() % 220 * 100;
    std::puts("kind,points,raw_us,ours_us,ratio");
    compare("ipc", "ipc://" + directory.string() + "/raw", {.directory = directory});
    compare("tcp", "tcp://127.0.0.1:" + std::to_string(port + 50),
            {.directory = directory, .address = "tcp://127.0.0.1:" + std::to_string(port)});
    std::filesystem::remove_all(directory);
}
