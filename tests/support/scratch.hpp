#pragma once

#include "coupler/base/scratch_directory.hpp"

namespace in_threads {

//! A directory that is removed with everything in it.
class Scratch : public sluice::ScratchDirectory
{
 public:
    Scratch() : ScratchDirectory("sluice-test") {}
};

}  // namespace in_threads
