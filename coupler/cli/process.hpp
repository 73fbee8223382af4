#pragma once

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace sluice {

//! How a process ended.
struct Ending
{
    int code = 0;    //!< exit code, if signal is 0
    int signal = 0;  //!< the signal that ended it
    bool well() const { return code == 0 && signal == 0; }
};

//! What happens to a log that is there: a process that is started again goes on with it.
enum class Log
{
    replace,
    append
};

//! A child process that does not outlive this one: it is killed when this process ends, however that happens.
class Process
{
 public:
    //! Starts argv[0] (looked up on PATH if it has no slash) with output and errors going to `log`.
    //! Throws Error (exit 7) if it cannot be started.
    Process(std::vector<std::string> const& argv, std::filesystem::path const& log,
            std::vector<std::pair<std::string, std::string>> const& environment = {}, Log mode = Log::replace);
    Process(Process&& other) noexcept;
    Process& operator=(Process&&) = delete;
    ~Process();  //!< kills and reaps

    std::optional<Ending> poll();                                    //!< how it ended, if it has
    std::optional<Ending> poll(std::chrono::milliseconds patience);  //!< the same, within that time
    Ending wait();
    pid_t pid() const { return pid_; }
    void signal(int number) const;         //!< to it and to what it started, also after it has ended itself
    void signal_itself(int number) const;  //!< to it alone, while it runs

 private:
    pid_t pid_ = -1;
    std::optional<Ending> ending_;
};

//! Makes this process the parent of what its children leave behind, so that end_orphans() finds them.
void adopt_orphans();
//! Kills and reaps every child of this process, adopted ones included.
void end_orphans();

//! The executable `name` beside this one, or on PATH; empty if there is none.
std::filesystem::path find_executable(std::string const& name);

//! The directory of this executable.
std::filesystem::path own_directory();

//! The last lines of a text file, at most `count`, indented; empty if it has none.
std::string last_lines(std::filesystem::path const& file, std::size_t count);

}  // namespace sluice
