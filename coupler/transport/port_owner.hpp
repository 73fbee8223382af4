#pragma once

#include <string>

namespace sluice {

//! Who listens on a tcp port of this host: "process 123 (name)"; "another process" where it is another user's.
std::string port_owner(int port);

}  // namespace sluice
