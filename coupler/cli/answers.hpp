#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "coupler/scene/scene.hpp"

//! Answers in JSON, for scripts and editors.
namespace sluice {

//! The lines of a message as mistakes: `file:line:column: text` gets its place, anything else is a text alone.
nlohmann::ordered_json mistakes_of(std::string const& message);

//! Participants, couplings and implicit groups of a scene.
nlohmann::ordered_json topology(Scene const& scene);

//! One value and a line end on standard output; bytes that are not UTF-8 are replaced.
void print_json(nlohmann::ordered_json const& value);

}  // namespace sluice
