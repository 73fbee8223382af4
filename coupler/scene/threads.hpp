#pragma once

#include <string_view>

#include "coupler/scene/reader.hpp"

namespace sluice {

//! `threads: auto` (all cores) or a number from 1 to 1024; absent: `fallback`, which may be auto.
int read_threads(Reader& reader, std::string_view fallback, int processes = 1);

}  // namespace sluice
