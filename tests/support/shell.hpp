#pragma once

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

//! Runs commands as a user would, for tests of the executables.
namespace shell {

struct Result
{
    int exit = -1;       //!< exit code; -1: still running; 128 + n: ended by signal n
    std::string output;  //!< standard output and error
    double seconds = 0;
};

inline std::string slurp(std::filesystem::path const& file)
{
    std::ifstream in(file, std::ios::binary);
    std::stringstream text;
    text << in.rdbuf();
    return text.str();
}

//! A command that goes on in the background, its output in a file.
class Background
{
 public:
    Background(std::vector<std::string> words, std::filesystem::path log) : log_(std::move(log))
    {
        std::vector<char*> argv;
        for (auto& word : words) argv.push_back(word.data());
        argv.push_back(nullptr);
        pid_ = ::fork();
        if (pid_ == 0) {
            int const file = ::open(log_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
            ::dup2(file, 1);
            ::dup2(file, 2);
            ::execv(argv[0], argv.data());
            ::_exit(127);
        }
    }
    Background(Background const&) = delete;
    Background& operator=(Background const&) = delete;
    ~Background()
    {
        if (!ended_) ::kill(pid_, SIGKILL), ::waitpid(pid_, nullptr, 0);
    }

    void signal(int number) const { ::kill(pid_, number); }
    pid_t pid() const { return pid_; }

    //! Waits at most `seconds`; exit -1 if it is still running then.
    Result wait(double seconds)
    {
        auto const begin = std::chrono::steady_clock::now();
        Result result;
        auto passed = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count(); };
        while (!ended_ && passed() < seconds) {
            int status = 0;
            if (::waitpid(pid_, &status, WNOHANG) == pid_) {
                ended_ = true;
                exit_ = WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
            } else
                std::this_thread::sleep_for(std::chrono::milliseconds(5));
        }
        result.exit = ended_ ? exit_ : -1;
        result.output = slurp(log_);
        result.seconds = passed();
        return result;
    }

 private:
    std::filesystem::path log_;
    pid_t pid_ = -1;
    bool ended_ = false;
    int exit_ = -1;
};

inline Result run(std::vector<std::string> const& words, std::filesystem::path const& log, double seconds = 300)
{
    return Background(words, log).wait(seconds);
}

//! How many processes have `text` in their command line, this one and its shell aside.
inline int processes_with(std::string const& text)
{
    int count = 0;
    for (auto const& entry : std::filesystem::directory_iterator("/proc")) {
        auto const name = entry.path().filename().string();
        if (name.find_first_not_of("0123456789") != std::string::npos || name == std::to_string(::getpid())) continue;
        auto line = slurp(entry.path() / "cmdline");
        for (char& c : line)
            if (c == '\0') c = ' ';
        if (line.find(text) != std::string::npos) ++count;
    }
    return count;
}

}  // namespace shell
