#pragma once

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstring>
#include <stdexcept>
#include <string>

//! TCP ports for tests that run side by side.
namespace ports {

constexpr int first = 10'000, block = 200, blocks = 113;  // below 32 768: the kernel gives away the others itself

//! Holds a name of the machine's abstract sockets until the process ends; false if another process does.
inline bool claim(int number)
{
    sockaddr_un name = {};
    name.sun_family = AF_UNIX;
    auto const text = "sluice-test-ports-" + std::to_string(number);
    std::memcpy(name.sun_path + 1, text.data(), text.size());
    int const held = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    auto const size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + text.size());
    if (held >= 0 && ::bind(held, reinterpret_cast<sockaddr const*>(&name), size) == 0) return true;
    ::close(held);
    return false;
}

inline int claimed_block()
{
    for (int i = 0; i < blocks; ++i)
        if (int const number = (::getpid() + i) % blocks; claim(number)) return first + number * block;
    throw std::runtime_error("no block of ports is left for this test");
}

//! The first of `count` consecutive ports that no other test process uses. They come round again after 200.
inline int take(int count = 10)
{
    static int const begin = claimed_block();
    static int used = 0;
    if (used + count > block) used = 0;
    used += count;
    return begin + used - count;
}

}  // namespace ports
