#pragma once

#include <filesystem>
#include <string>

#include "coupler/scene/scene.hpp"

namespace sluice {

//! The topology in graphviz's DOT: a box per participant, an arrow per coupling with its data and lag.
std::string to_dot(Scene const& scene);

//! Draws DOT as the picture that the file's ending names (.svg, .png, .pdf). Throws Error (exit 7) without graphviz.
void draw(std::string const& dot, std::filesystem::path const& picture);

}  // namespace sluice
