#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace sluice {

//! Holds a file for the life of the process, so that a second process of the same name in the same place is noticed.
class NameLock
{
 public:
    //! Throws Error (exit 7) if the file cannot be made, (exit 5) with `taken` and the owner's process id if it is
    //! held.
    NameLock(std::filesystem::path const& file, std::string const& taken);
    NameLock(NameLock const&) = delete;
    NameLock& operator=(NameLock const&) = delete;
    ~NameLock();

 private:
    int file_ = -1;
};

}  // namespace sluice
