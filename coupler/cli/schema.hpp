#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

namespace sluice {

//! The JSON Schema (draft 07) of a scene: made of the keys that the code asks for, the words about them and the rules
//! between keys, both in schema_words.cpp. The blocks `config` are left open: they belong to the solvers.
nlohmann::ordered_json scene_schema();

//! What stands beside a key, by its pattern ("couplings[].lag"): what the key means.
std::vector<std::pair<std::string, std::string>> const& meanings();

//! Rules that bounds and choices do not say, by the pattern of the mapping that they hold in ("": the scene).
std::vector<std::pair<std::string, nlohmann::ordered_json>> rules();

}  // namespace sluice
