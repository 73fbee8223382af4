// Preloaded into a process: what it connects to port SLUICE_REDIRECT of 127.0.0.1 goes to 127.0.0.2, where a proxy of
// the test listens. So a run between executables passes through a network that does what the test wants.

#include <arpa/inet.h>
#include <dlfcn.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <cstdlib>
#include <cstring>

extern "C" int connect(int socket, sockaddr const* address, socklen_t size)
{
    static auto const real = reinterpret_cast<int (*)(int, sockaddr const*, socklen_t)>(::dlsym(RTLD_NEXT, "connect"));
    static char const* const port = std::getenv("SLUICE_REDIRECT");
    if (!port || address->sa_family != AF_INET || size < sizeof(sockaddr_in)) return real(socket, address, size);
    sockaddr_in to = {};
    std::memcpy(&to, address, sizeof to);
    if (to.sin_addr.s_addr == htonl(INADDR_LOOPBACK) && ntohs(to.sin_port) == std::atoi(port))
        to.sin_addr.s_addr = htonl(INADDR_LOOPBACK + 1);
    return real(socket, reinterpret_cast<sockaddr const*>(&to), sizeof to);
}
