#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>

#include "coupler/base/error.hpp"

namespace sluice {

//! A directory in /tmp that is gone with the object. Throws Error (exit 7) if none can be made.
class ScratchDirectory
{
 public:
    explicit ScratchDirectory(std::string const& name)
    {
        auto pattern = "/tmp/" + name + "-XXXXXX";
        require(::mkdtemp(pattern.data()) != nullptr,
                [] { return Error("/tmp: no directory can be made there.", Exit::io); });
        path_ = pattern;
    }
    ScratchDirectory(ScratchDirectory const&) = delete;
    ScratchDirectory& operator=(ScratchDirectory const&) = delete;
    ~ScratchDirectory()
    {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }
    std::filesystem::path const& path() const { return path_; }

 private:
    std::filesystem::path path_;
};

}  // namespace sluice
