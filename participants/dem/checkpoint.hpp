#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "participants/dem/state.hpp"

namespace dem {

//! The whole state as bytes: a solver restored from it continues bit for bit. For the same machine and version.
std::vector<std::byte> to_bytes(State const& state);

//! Throws sluice::Error (io) if the bytes are not a state of `grains` grains and `walls` walls.
State state_from_bytes(std::span<std::byte const> bytes, std::size_t grains, std::size_t walls);

}  // namespace dem
