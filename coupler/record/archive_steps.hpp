#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>

namespace sluice {

struct CopiedSteps
{
    std::size_t count = 0;
    std::string damage;  //!< why not all of them, if the other archive could not be read to the end
};

//! Copies the steps of the archive `from` up to the time `until` [s] into the open HDF5 file `to`, chunks as they are
//! (nothing is unpacked), each wholly or not at all. `from` may be what a killed run left. Throws Error (Exit::io) only
//! for `to`.
CopiedSteps copy_steps(std::filesystem::path const& from, std::int64_t to, double until);

//! The group of a step: "/steps/000012".
std::string step_name(std::size_t step);

}  // namespace sluice
