#include "participants/liggghts/classes.hpp"

#include <algorithm>
#include <cmath>

namespace liggghts {

SizeClasses classes_of(std::span<double const> mass, std::span<double const> radius, std::size_t most)
{
    SizeClasses found;
    found.of.resize(mass.size());
    if (mass.empty()) return found;
    std::vector<double> masses(mass.begin(), mass.end());
    std::sort(masses.begin(), masses.end());
    masses.erase(std::unique(masses.begin(), masses.end()), masses.end());
    bool const each = masses.size() <= most;
    double const least = masses.front(), span = std::log(masses.back() / least);
    auto const class_of = [&](double m) -> std::size_t {
        if (each) return static_cast<std::size_t>(std::lower_bound(masses.begin(), masses.end(), m) - masses.begin());
        auto const at = std::log(m / least) / span * static_cast<double>(most);
        return std::min(static_cast<std::size_t>(at), most - 1);
    };
    std::size_t const count = each ? masses.size() : most;
    std::vector<double> log_mass(count), sum_radius(count), members(count);
    for (std::size_t i = 0; i < mass.size(); ++i) {
        std::size_t const c = found.of[i] = class_of(mass[i]);
        log_mass[c] += std::log(mass[i]);
        sum_radius[c] += radius[i];
        members[c] += 1.0;
    }
    for (std::size_t c = 0; c < count; ++c) {
        double const middle = least * std::exp(span * (static_cast<double>(c) + 0.5) / static_cast<double>(count));
        if (each)
            found.classes.push_back({masses[c], sum_radius[c] / members[c]});
        else if (members[c] > 0.0)
            found.classes.push_back({std::exp(log_mass[c] / members[c]), sum_radius[c] / members[c]});
        else
            found.classes.push_back({middle, radius[0] * std::cbrt(middle / mass[0])});  // nobody's
    }
    for (std::size_t i = 0; i < mass.size(); ++i)
        found.spread = std::max(found.spread, std::abs(std::sqrt(mass[i] / found.classes[found.of[i]].mass) - 1.0));
    return found;
}

}  // namespace liggghts
