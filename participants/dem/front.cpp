#include "participants/dem/front.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace dem {

std::vector<double> reach_of(Grains<3> const& grains, Sectors const& sectors)
{
    std::vector<double> reach(sectors.count, 0.0);
    double const width = sectors.angle / static_cast<double>(sectors.count);
    for (auto const& [centre, radius] : grains.place) {
        double angle = std::atan2(centre.y, centre.x);
        if (angle < 0.0 && sectors.angle > std::numbers::pi) angle += 2.0 * std::numbers::pi;
        double const place = std::clamp(std::floor(angle / width), 0.0, static_cast<double>(sectors.count - 1));
        double& furthest = reach[static_cast<std::size_t>(place)];
        furthest = std::max(furthest, std::hypot(centre.x, centre.y) + radius);
    }
    return reach;
}

double front_of(std::vector<double> const& reach, double percentile)
{
    std::vector<double> sorted;
    for (double const r : reach)
        if (r > 0.0) sorted.push_back(r);
    if (sorted.empty()) return 0.0;
    std::sort(sorted.begin(), sorted.end());
    double const rank = 0.01 * percentile * static_cast<double>(sorted.size() - 1);
    auto const below = static_cast<std::size_t>(rank);
    double limit = sorted[below];
    if (below + 1 < sorted.size()) limit += (rank - static_cast<double>(below)) * (sorted[below + 1] - sorted[below]);
    double sum = 0.0, kept = 0.0;
    for (double const r : sorted)
        if (r <= limit) sum += r, kept += 1.0;
    return sum / kept;
}

}  // namespace dem
