#pragma once

#include <filesystem>
#include <string>

namespace sluice {

//! A listener's file in the run's private directory. Locked: it is this process that listens, and nobody else may.
//! Opened: its ports are bound. Whoever connects only to an open door reaches the listener itself: a stranger can
//! neither hold the ports then nor enter the directory. Locks go with the process, however it ends.
class Door
{
 public:
    //! Throws Error (exit 5) if another process holds it, naming that one; (exit 7) if there can be no file.
    Door(std::filesystem::path const& directory, int member, std::string const& name);
    Door(Door const&) = delete;
    Door& operator=(Door const&) = delete;
    ~Door();

    void open();
    static bool is_open(std::filesystem::path const& directory, int member);

 private:
    int file_ = -1;
};

//! Throws Error (exit 8) unless `directory` is this user's and nobody else can enter it.
void require_private(std::filesystem::path const& directory);

//! 64 random characters that all processes of a run find in its private directory: the first one makes them.
//! Throws Error (exit 7), or (exit 8) if others could have read them.
std::string run_secret(std::filesystem::path const& directory);

}  // namespace sluice
