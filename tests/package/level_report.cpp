#include <signal.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>

//! Stands for a solver: says how it was started; `exit N` and `signal N` say how it is to end.
int main(int argc, char** argv)
{
    int death_signal = 0;
    ::prctl(PR_GET_PDEATHSIG, &death_signal);
    char const* const word = std::getenv("LEVEL_TEST");
    std::printf("called %s\npid %d\nparent-death signal %d\nenvironment %s\n", argv[0], static_cast<int>(::getpid()),
                death_signal, word ? word : "");
    char path[4096] = {};
    if (::readlink("/proc/self/exe", path, sizeof path - 1) > 0) std::printf("file %s\n", path);
    for (int k = 1; k < argc; ++k) std::printf("word %s\n", argv[k]);
    std::fflush(stdout);
    if (argc > 2 && std::strcmp(argv[1], "signal") == 0) ::raise(std::atoi(argv[2]));
    return argc > 2 && std::strcmp(argv[1], "exit") == 0 ? std::atoi(argv[2]) : 0;
}
