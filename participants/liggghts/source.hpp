#pragma once

#include <filesystem>
#include <string>

#include "coupler/scene/reader.hpp"
#include "participants/dem/config.hpp"
#include "participants/liggghts/engine.hpp"

namespace liggghts {

//! Where a run's grains and laws come from: the block that our DEM reads, or an input script of the user's.
struct Source
{
    dem::Config config;            //!< of a user's script: step, gravity and measures alone
    std::filesystem::path script;  //!< the user's; empty: one is generated

    bool generates() const { return script.empty(); }
};

//! Reads the block; mistakes, and what LIGGGHTS cannot do, go to the reader, which throws.
Source read_source(sluice::Reader reader, int dimension, dem::Vec3 gravity);

//! Gives an input script to LIGGGHTS, command by command, so that a mistake has its file and line. It has variables:
//! `folder` where the script is, `resumed` 1 if grains come from the file `restart`, else 0.
void run_script(Engine& engine, std::filesystem::path const& script, std::filesystem::path const& restart);

}  // namespace liggghts
