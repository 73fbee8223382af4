#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace sluice {

//! CURVE keys in a directory: NAME.public may be shown to anybody, NAME.secret to nobody; Z85 text of 40 characters.
struct KeyPair
{
    std::string open;    //!< public
    std::string secret;  //!< never in a message, log or report
};

//! Throws Error (exit 8) if one of the names has a key there already: others may trust it.
void require_no_keys(std::filesystem::path const& directory, std::vector<std::string> const& names);

//! Writes NAME.public (0644) and NAME.secret (0600). Throws Error (exit 8) if one of them is there already, (exit 7) if
//! it cannot be written.
void make_key_pair(std::filesystem::path const& directory, std::string const& name);

//! Throws Error (exit 8): no such file, no key in it, others can read the secret, or the two do not belong together.
KeyPair read_key_pair(std::filesystem::path const& directory, std::string const& name);

//! Throws Error (exit 8): no such file, no key in it, or others can change it.
std::string read_public_key(std::filesystem::path const& directory, std::string const& name);

}  // namespace sluice
