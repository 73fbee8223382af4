#include "coupler/transport/port_owner.hpp"

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>

namespace sluice {
namespace {

constexpr unsigned listening = 0x0A;  // TCP_LISTEN in the fourth column of /proc/net/tcp

//! "socket:[INODE]" of whoever listens on `port`.
std::optional<std::string> listening_socket(char const* table, int port)
{
    std::ifstream in(table);
    std::string line;
    while (std::getline(in, line)) {
        unsigned local = 0, state = 0;
        unsigned long inode = 0;
        // sl: local_address rem_address st tx:rx tr:when retrnsmt uid timeout inode (proc(5))
        int const found = std::sscanf(line.c_str(), " %*d: %*[0-9A-F]:%x %*[0-9A-F]:%*x %x %*s %*s %*s %*u %*u %lu",
                                      &local, &state, &inode);
        if (found == 3 && static_cast<int>(local) == port && state == listening)
            return "socket:[" + std::to_string(inode) + "]";
    }
    return std::nullopt;
}

bool holds(std::filesystem::path const& process, std::string const& socket)
{
    std::error_code error;
    for (std::filesystem::directory_iterator it(process / "fd", error), end; !error && it != end; it.increment(error)) {
        std::error_code unreadable;
        if (std::filesystem::read_symlink(it->path(), unreadable) == socket) return true;
    }
    return false;
}

}  // namespace

std::string port_owner(int port)
{
    std::string const unknown = "another process";
    auto socket = listening_socket("/proc/net/tcp", port);
    if (!socket) socket = listening_socket("/proc/net/tcp6", port);
    if (!socket) return unknown;
    std::error_code error;
    for (std::filesystem::directory_iterator it("/proc", error), end; !error && it != end; it.increment(error)) {
        auto const pid = it->path().filename().string();
        if (pid.find_first_not_of("0123456789") != std::string::npos || !holds(it->path(), *socket)) continue;
        std::string name;
        std::ifstream file(it->path() / "comm");
        std::getline(file, name);
        return "process " + pid + " (" + name + ")";
    }
    return unknown;
}

}  // namespace sluice
