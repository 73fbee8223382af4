#include "coupler/record/archive_steps.hpp"

#include <fmt/format.h>

#include <optional>

#include "coupler/base/error.hpp"
#include "coupler/record/hdf5_handle.hpp"

namespace sluice {
namespace {

using hdf5::check;
using hdf5::Handle;

//! The time of a step [s]; nothing when there is no such step. Throws Error (Exit::io) for one that cannot be read.
std::optional<double> time_of(hid_t file, std::string const& step)
{
    htri_t const there = H5Lexists(file, step.c_str(), H5P_DEFAULT);
    check(there, "its link");
    if (there == 0) return std::nullopt;
    Handle const attribute(H5Aopen_by_name(file, step.c_str(), "time", H5P_DEFAULT, H5P_DEFAULT), H5Aclose, "its time");
    double time = 0;
    check(H5Aread(attribute.get(), H5T_NATIVE_DOUBLE, &time), "its time");
    return time;
}

}  // namespace

std::string step_name(std::size_t step)
{
    return fmt::format("/steps/{:06}", step);
}

CopiedSteps copy_steps(std::filesystem::path const& from, std::int64_t to, double until)
{
    CopiedSteps copied;
    try {
        Handle const file(H5Fopen(from.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose, "it does not open");
        for (;; ++copied.count) {
            auto const step = step_name(copied.count);
            auto const time = time_of(file.get(), step);
            if (!time || *time > until) return copied;
            bool const well = H5Ocopy(file.get(), step.c_str(), to, step.c_str(), H5P_DEFAULT, H5P_DEFAULT) >= 0;
            if (well) continue;
            copied.damage = fmt::format("step {}: {}", copied.count, hdf5::reason());
            if (H5Lexists(to, step.c_str(), H5P_DEFAULT) > 0)
                check(H5Ldelete(to, step.c_str(), H5P_DEFAULT), "half a step");
            return copied;
        }
    } catch (Error const& error) {
        copied.damage = fmt::format("step {}: {}", copied.count, error.what());
    }
    return copied;
}

}  // namespace sluice
