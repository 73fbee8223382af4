#pragma once

#include <vector>

#include "coupler/scene/key.hpp"

namespace sluice {

//! Every key that a scene may have, in the order in which the code asks for them, found by reading scenes that have all
//! of them. Paths are patterns: "participants.*.solver", "couplings[].lag". A key that is read in two ways stands here
//! twice. `required`: whenever its mapping is there. A fallback that depends on other keys is left out.
std::vector<Key> scene_keys();

}  // namespace sluice
