#include "coupler/scene/units.hpp"

#include <algorithm>
#include <vector>

#include "coupler/scene/parts.hpp"

namespace sluice {
namespace {

//! SI: the base units (with kg) and the derived ones with names of their own. Source: BIPM, SI Brochure (2019), tables
//! 2 and 4; degree Celsius is left out, a scale with another zero.
std::vector<std::string> const& si_units()
{
    static std::vector<std::string> const units = {"m", "kg", "s",  "A",  "K",  "mol", "cd", "rad", "sr", "Hz",
                                                   "N", "Pa", "J",  "W",  "C",  "ohm", "V",  "F",   "S",  "Wb",
                                                   "T", "H",  "lm", "lx", "Bq", "Gy",  "Sv", "kat"};
    return units;
}

struct Other
{
    std::string unit, instead;
};

//! What people write beside those: prefixes, and units that the SI Brochure (table 8) accepts.
std::vector<Other> const& other_units()
{
    static std::vector<Other> const units = [] {
        std::vector<Other> list = {{"g", "kg"},
                                   {"t", "kg"},
                                   {"min", "s"},
                                   {"h", "s"},
                                   {"d", "s"},
                                   {"L", "m3"},
                                   {"l", "m3"},
                                   {"bar", "Pa"},
                                   {"atm", "Pa"},
                                   {"deg", "rad"},
                                   {"\xc2\xb0", "rad"},
                                   {"degC", "K"},
                                   {"\xc2\xb0"
                                    "C",
                                    "K"},
                                   {"rpm", "rad/s"},
                                   {"%", "1"},
                                   {"ppm", "1"},
                                   {"eV", "J"},
                                   {"cm", "m"},
                                   {"dm", "m"}};
        for (char const* prefix : {"n", "u", "\xc2\xb5", "m", "k", "M", "G"})
            for (char const* unit : {"m", "g", "s", "A", "K", "mol", "Hz", "N", "Pa", "J", "W", "V", "L", "bar"}) {
                Other other{std::string(prefix) + unit, unit};
                if (other.unit == "kg") continue;
                if (other.instead == "g") other.instead = "kg";
                if (other.instead == "L") other.instead = "m3";
                if (other.instead == "bar") other.instead = "Pa";
                list.push_back(other);
            }
        return list;
    }();
    return units;
}

bool is_si(std::string_view name)
{
    return std::find(si_units().begin(), si_units().end(), name) != si_units().end();
}

//! "m^-2" -> "m": a power is one digit, with ^ and a sign if they are there.
std::string_view without_power(std::string_view factor)
{
    auto end = factor.size();
    if (end > 1 && factor[end - 1] >= '1' && factor[end - 1] <= '9') {
        --end;
        if (end > 1 && factor[end - 1] == '-') --end;
        if (end > 1 && factor[end - 1] == '^') --end;
    }
    return factor.substr(0, end);
}

constexpr std::string_view separators = " */";

}  // namespace

UnitCheck check_unit(std::string_view text)
{
    UnitCheck check{.known = true, .odd = {}, .instead = {}};
    if (text == "1" || text == "1.0" || text == "-") return check;
    if (text.starts_with("1/")) text.remove_prefix(2);
    while (check.known) {
        auto const end = std::min(text.find_first_of(separators), text.size());
        std::string const factor(text.substr(0, end));
        std::string const name(without_power(factor));
        auto const other =
            std::find_if(other_units().begin(), other_units().end(), [&](Other const& o) { return o.unit == name; });
        bool const is_other = other != other_units().end();
        if (!is_si(name)) {
            if (!is_other || check.odd.empty()) {
                check.odd = is_other ? name : factor;
                check.instead = is_other ? other->instead : "";
            }
            check.known = is_other;
        }
        if (end == text.size()) break;
        text.remove_prefix(end + 1);
    }
    return check;
}

std::string unit_pattern()
{
    std::string names;
    auto add = [&](std::string const& name) { names += (names.empty() ? "" : "|") + name; };
    for (auto const& name : si_units()) add(name);
    for (auto const& other : other_units()) add(other.unit);
    return "^(1(\\.0)?|-|(1/)?((" + names + ")(\\^?-?[1-9])?([ */](?!$)|$))+)$";
}

std::string read_unit(Reader& column)
{
    auto const unit = column.text("unit");
    if (unit.empty()) return unit;
    auto const check = check_unit(unit);
    auto known = si_units();
    if (!check.known)
        column.refuse("unit", "is not a unit: \"" + check.odd +
                                  "\" (needed: a product of SI units with powers, e.g. m/s2, " + "N m, W/m2/K, 1)." +
                                  did_you_mean(check.odd, known));
    else if (!check.odd.empty())
        column.warn("unit", "is accepted, but " + check.odd + " is not SI (needed: " + check.instead +
                                "). Nothing is converted: both ends must mean the same.");
    return unit;
}

}  // namespace sluice
