#pragma once

#include "participants/mpm/laws.hpp"

namespace sluice {
class Reader;
}

namespace mpm {

//! The law of a `material:` block, whose density has been read.
Law read_law(sluice::Reader& material);

Elasticity const& elasticity_of(Law const& law);

}  // namespace mpm
