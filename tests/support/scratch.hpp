#pragma once

#include <cstdlib>
#include <filesystem>

namespace in_threads {

//! A directory that is removed with everything in it.
class Scratch
{
 public:
    Scratch()
    {
        char pattern[] = "/tmp/sluice-test-XXXXXX";
        path_ = ::mkdtemp(pattern);
    }
    Scratch(Scratch const&) = delete;
    Scratch& operator=(Scratch const&) = delete;
    ~Scratch()
    {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }
    std::filesystem::path const& path() const { return path_; }

 private:
    std::filesystem::path path_;
};

}  // namespace in_threads
