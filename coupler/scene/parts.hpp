#pragma once

#include <string>

#include "coupler/scene/scene.hpp"

//! The parts of a scene that are read in files of their own; for the files of this folder.
namespace sluice {

//! `host`: an address or a name, or empty.
std::string read_host(Reader& participant);
//! `unit`: a product of SI units; others get a warning or are refused.
std::string read_unit(Reader& column);
//! transport, address, port, security, remote; after the participants.
void read_network(Reader& root, Scene& scene);
//! frame: inertial, or rotating.
void read_frame(Reader& root, Scene& scene);
//! implicit: groups that repeat a window; after the couplings, and whether those have no mistakes.
void read_implicit(Reader& root, Scene& scene, bool couplings_known);

}  // namespace sluice
