#pragma once

#include <sys/mount.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <string>

namespace sluice::test {

//! A fresh folder that is gone at the end of the test.
class Folder
{
 public:
    explicit Folder(std::filesystem::path const& parent = std::filesystem::temp_directory_path())
    {
        std::string pattern = (parent / "record_XXXXXX").string();
        path_ = ::mkdtemp(pattern.data());
    }
    Folder(Folder const&) = delete;
    Folder& operator=(Folder const&) = delete;
    ~Folder()
    {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }
    std::filesystem::path operator/(std::string const& name) const { return path_ / name; }
    std::filesystem::path const& path() const { return path_; }

 private:
    std::filesystem::path path_;
};

//! Where files are in memory, for tests that write thousands: others keep a disk busy. Else the usual place.
inline std::filesystem::path memory_folder()
{
    return ::access("/dev/shm", W_OK) == 0 ? std::filesystem::path("/dev/shm") : std::filesystem::temp_directory_path();
}

//! A file system of one megabyte, mounted on a fresh folder; needs root.
class SmallDisk
{
 public:
    SmallDisk() : mounted_(::mount("tmpfs", folder_.path().c_str(), "tmpfs", 0, "size=1m") == 0) {}
    SmallDisk(SmallDisk const&) = delete;
    SmallDisk& operator=(SmallDisk const&) = delete;
    ~SmallDisk()
    {
        if (mounted_) ::umount2(folder_.path().c_str(), MNT_DETACH);
    }
    bool mounted() const { return mounted_; }
    std::filesystem::path operator/(std::string const& name) const { return folder_ / name; }
    std::filesystem::path const& path() const { return folder_.path(); }

 private:
    Folder folder_;
    bool mounted_;
};

}  // namespace sluice::test
