#include "coupler/cli/process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <fstream>
#include <sstream>
#include <utility>

#include "coupler/base/error.hpp"

namespace sluice {
namespace {

//! Runs in the child between fork and exec: async-signal-safe calls only. Reports errno through the pipe.
[[noreturn]] void become(char* const* argv, char const* log, int flags, pid_t parent, int report)
{
    ::setsid();  // a group of its own, and no terminal: nobody may ask for a password there
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() != parent) ::_exit(127);  // the parent ended before the line above
    int const file = ::open(log, O_WRONLY | O_CREAT | flags, 0644);
    int const null = ::open("/dev/null", O_RDONLY);
    if (file >= 0 && null >= 0) {
        ::dup2(null, 0);
        ::dup2(file, 1);
        ::dup2(file, 2);
        ::execvp(argv[0], argv);
    }
    int const error = errno;
    if (::write(report, &error, sizeof error) < 0) ::_exit(126);
    ::_exit(127);
}

Error cannot_start(std::string const& program, int error)
{
    return Error(program + ": cannot be started: " + std::strerror(error) + "." +
                     (error == EMFILE || error == ENFILE ? " Raise `ulimit -n`." : ""),
                 Exit::io);
}

}  // namespace

Process::Process(std::vector<std::string> const& words, std::filesystem::path const& log,
                 std::vector<std::pair<std::string, std::string>> const& environment, Log mode)
{
    for (auto const& [name, value] : environment) ::setenv(name.c_str(), value.c_str(), 1);
    std::vector<std::string> copy = words;
    std::vector<char*> argv;
    for (auto& word : copy) argv.push_back(word.data());
    argv.push_back(nullptr);
    int report[2];
    require(::pipe2(report, O_CLOEXEC) == 0, [&] { return cannot_start(words[0], errno); });
    pid_t const parent = ::getpid();
    pid_ = ::fork();
    if (pid_ == 0) become(argv.data(), log.c_str(), mode == Log::append ? O_APPEND : O_TRUNC, parent, report[1]);
    ::close(report[1]);
    int error = pid_ < 0 ? errno : 0;
    if (pid_ > 0 && ::read(report[0], &error, sizeof error) == sizeof error) ::waitpid(pid_, nullptr, 0);
    ::close(report[0]);
    require(error == 0, [&] {
        pid_ = -1;
        return cannot_start(words[0], error);
    });
}

Process::Process(Process&& other) noexcept
    : pid_(std::exchange(other.pid_, -1)), ending_(std::exchange(other.ending_, std::nullopt))
{}

Process::~Process()
{
    if (pid_ < 0) return;
    signal(SIGKILL);
    wait();
}

std::optional<Ending> Process::poll()
{
    if (ending_ || pid_ < 0) return ending_;
    int status = 0;
    if (::waitpid(pid_, &status, WNOHANG) == pid_)
        ending_ = WIFSIGNALED(status) ? Ending{0, WTERMSIG(status)} : Ending{WEXITSTATUS(status), 0};
    return ending_;
}

std::optional<Ending> Process::poll(std::chrono::milliseconds patience)
{
    if (poll() || pid_ < 0) return ending_;
    pollfd watched = {static_cast<int>(::syscall(SYS_pidfd_open, pid_, 0)), POLLIN, 0};
    (void)::poll(&watched, watched.fd < 0 ? 0 : 1, static_cast<int>(patience.count()));
    if (watched.fd >= 0) ::close(watched.fd);
    return poll();
}

Ending Process::wait()
{
    while (!ending_) {
        int status = 0;
        if (::waitpid(pid_, &status, 0) == pid_)
            ending_ = WIFSIGNALED(status) ? Ending{0, WTERMSIG(status)} : Ending{WEXITSTATUS(status), 0};
        else if (errno != EINTR)
            ending_ = Ending{127, 0};
    }
    return *ending_;
}

void Process::signal(int number) const
{
    if (pid_ > 0) ::kill(-pid_, number);  // its group: no such group once all of it has ended
}

void Process::signal_itself(int number) const
{
    if (pid_ > 0 && !ending_) ::kill(pid_, number);
}

void adopt_orphans()
{
    ::prctl(PR_SET_CHILD_SUBREAPER, 1);
}

void end_orphans()
{
    for (int round = 0; round < 100; ++round) {  // killed children hand their own over to us
        std::ifstream children("/proc/self/task/" + std::to_string(::getpid()) + "/children");
        bool any = false;
        for (pid_t child = 0; children >> child; any = true) {
            ::kill(child, SIGKILL);
            ::waitpid(child, nullptr, 0);
        }
        if (!any) return;
    }
}

std::filesystem::path own_directory()
{
    return std::filesystem::read_symlink("/proc/self/exe").parent_path();
}

std::filesystem::path find_executable(std::string const& name)
{
    auto usable = [](std::filesystem::path const& p) {
        return std::filesystem::is_regular_file(p) && ::access(p.c_str(), X_OK) == 0;
    };
    if (name.find('/') != std::string::npos) return usable(name) ? name : "";
    if (auto const beside = own_directory() / name; usable(beside)) return beside;
    char const* const path = std::getenv("PATH");
    std::stringstream folders(path ? path : "");
    for (std::string folder; std::getline(folders, folder, ':');)
        if (auto const candidate = std::filesystem::path(folder) / name; usable(candidate)) return candidate;
    return {};
}

std::string last_lines(std::filesystem::path const& file, std::size_t count)
{
    std::ifstream in(file);
    std::deque<std::string> lines;
    for (std::string line; std::getline(in, line);) {
        if (line.empty()) continue;
        lines.push_back(line);
        if (lines.size() > count) lines.pop_front();
    }
    std::string text;
    for (auto const& line : lines) text += "\n    " + line;
    return text;
}

}  // namespace sluice
