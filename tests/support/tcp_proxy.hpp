#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

//! TCP on loopback as strangers and bad networks use it.
namespace tcp {

inline sockaddr_in address(std::string const& host, int port)
{
    sockaddr_in a = {};
    a.sin_family = AF_INET;
    a.sin_port = htons(static_cast<std::uint16_t>(port));
    ::inet_pton(AF_INET, host.c_str(), &a.sin_addr);
    return a;
}

//! -1 if nobody accepts within 0.2 s.
inline int connect(std::string const& host, int port)
{
    int const s = ::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    auto const to = address(host, port);
    if (::connect(s, reinterpret_cast<sockaddr const*>(&to), sizeof to) == 0) return s;
    pollfd item{s, POLLOUT, 0};
    int error = 0;
    socklen_t size = sizeof error;
    if (::poll(&item, 1, 200) == 1 && ::getsockopt(s, SOL_SOCKET, SO_ERROR, &error, &size) == 0 && error == 0) return s;
    ::close(s);
    return -1;
}

//! Throws when the port is taken.
inline int listen(std::string const& host, int port)
{
    int const s = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    int const one = 1;
    ::setsockopt(s, SOL_SOCKET, SO_REUSEADDR, &one, sizeof one);
    auto const at = address(host, port);
    if (::bind(s, reinterpret_cast<sockaddr const*>(&at), sizeof at) != 0 || ::listen(s, 16) != 0)
        throw std::runtime_error("port " + std::to_string(port) + " is taken");
    return s;
}

//! Relays from one loopback address to another; what passes can be held back, changed or cut.
class Proxy
{
 public:
    Proxy(std::string const& from, std::string to, int port)
        : to_(std::move(to)), port_(port), door_(listen(from, port))
    {
        thread_ = std::thread([this] { run(); });
    }
    Proxy(Proxy const&) = delete;
    Proxy& operator=(Proxy const&) = delete;
    ~Proxy()
    {
        stop_ = true;
        thread_.join();
        for (int s : sockets_) ::close(s);
        ::close(door_);
    }

    std::atomic<std::size_t> chunk{65'536};  //!< bytes that pass at once; fewer than that: every 5 ms
    std::atomic<bool> hold{false};           //!< nothing passes; connections stay
    std::atomic<bool> cut{false};            //!< connections are reset, once
    std::atomic<int> connections{0};         //!< so far

 private:
    void run()
    {
        while (!stop_) {
            if (cut.exchange(false)) reset_all();
            std::vector<pollfd> items{{door_, POLLIN, 0}};
            if (!hold)
                for (int s : sockets_) items.push_back({s, POLLIN, 0});
            if (::poll(items.data(), items.size(), 5) <= 0) continue;
            for (std::size_t i = 1; i < items.size(); ++i)
                if (items[i].revents != 0 && !relay(i - 1)) break;
            if (items[0].revents != 0 && !hold) accept_one();
        }
    }

    void accept_one()
    {
        int const in = ::accept4(door_, nullptr, nullptr, SOCK_CLOEXEC);
        int const out = connect(to_, port_);
        if (in < 0 || out < 0) {
            ::close(in);
            return;
        }
        ++connections;
        sockets_.insert(sockets_.end(), {in, out});
    }

    //! False: the pair is gone.
    bool relay(std::size_t i)
    {
        char bytes[65536];
        if (chunk < sizeof bytes) std::this_thread::sleep_for(std::chrono::milliseconds(5));
        auto const n = ::recv(sockets_[i], bytes, std::min<std::size_t>(chunk, sizeof bytes), MSG_DONTWAIT);
        if (n < 0 && errno == EAGAIN) return true;
        for (ssize_t sent = 0; n > 0 && sent < n;) {
            auto const k = ::send(sockets_[i ^ 1], bytes + sent, static_cast<std::size_t>(n - sent), MSG_NOSIGNAL);
            if (k > 0)
                sent += k;
            else if (errno != EAGAIN || stop_)
                break;
            else
                std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        if (n > 0) return true;
        auto const pair = sockets_.begin() + static_cast<std::ptrdiff_t>(i & ~std::size_t{1});
        ::close(pair[0]);
        ::close(pair[1]);
        sockets_.erase(pair, pair + 2);
        return false;
    }

    void reset_all()
    {
        linger const at_once{1, 0};
        for (int s : sockets_) {
            ::setsockopt(s, SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
            ::close(s);
        }
        sockets_.clear();
    }

    std::string to_;
    int port_;
    int door_;
    std::vector<int> sockets_;  //!< 2k and 2k + 1 belong together
    std::atomic<bool> stop_{false};
    std::thread thread_;
};

}  // namespace tcp
