#pragma once

#include <string>
#include <string_view>

namespace sluice {

//! What a text says as a unit: a product of units with powers, e.g. "kg m2/s", "W/m2/K", "1/s", or "1".
struct UnitCheck
{
    bool known = false;   //!< every factor is a unit
    std::string odd;      //!< the first factor that is no unit, or not of SI without a prefix; empty: there is none
    std::string instead;  //!< what is meant by it in SI, e.g. "m"; may be empty
};
UnitCheck check_unit(std::string_view text);

//! The same as a regular expression (of JSON Schema) for what is known.
std::string unit_pattern();

}  // namespace sluice
