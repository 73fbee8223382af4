#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace sluice {

//! How a run was started, in RUN/.sluice/run.json: what `sluice resume` needs to start it again.
struct RunRecord
{
    std::filesystem::path scene;    //!< absolute
    std::filesystem::path started;  //!< the directory it was started in: programs and files may be relative to it
    std::vector<std::string> set;   //!< path=value
    std::vector<double> parts;      //!< wall time of each part of the run that has ended, s

    static std::filesystem::path file(std::filesystem::path const& run) { return run / ".sluice" / "run.json"; }
    //! Throws Error (exit 7).
    void write(std::filesystem::path const& run) const;
    //! Throws Error (exit 7) if there is none or it is damaged.
    static RunRecord read(std::filesystem::path const& run);
};

}  // namespace sluice
