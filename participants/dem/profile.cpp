#include "participants/dem/profile.hpp"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <numbers>

#include "participants/dem/measures.hpp"

namespace dem {
namespace {

//! The part of a grain's volume on the near side of a plane at `depth` radii beyond its centre.
template <int D>
double part_before(double depth)
{
    double const t = std::clamp(depth, -1.0, 1.0);
    if constexpr (D == 2) return 0.5 + (t * std::sqrt(1.0 - t * t) + std::asin(t)) / std::numbers::pi;
    return 0.25 * (2.0 + 3.0 * t - t * t * t);
}

}  // namespace

std::vector<double> slice_positions(Bins const& bins, double low, double high)
{
    std::vector<double> middles;
    for (double slice = bins.slice(low); slice <= bins.slice(high); ++slice)
        middles.push_back((slice + 0.5) * bins.width);
    return middles;
}

template <int D>
Profile profile_of(Grains<D> const& g, Bins const& bins)
{
    Profile p;
    if (g.size() == 0) return p;
    std::vector<double> at(g.size());
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (std::size_t i = 0; i < g.size(); ++i) {
        at[i] = bins.position(g.place[i].centre);
        low = std::min(low, at[i] - g.place[i].radius);
        high = std::max(high, at[i] + g.place[i].radius);
    }
    if (bins.radial) low = 0.0;  // a grain on the axis lies in the first slice
    p.position = slice_positions(bins, low, high);
    p.mass.assign(p.position.size(), 0.0);
    p.surface.assign(p.position.size(), 0.0);
    auto const belongs = main_mass(g);
    double const origin = p.position.front() - 0.5 * bins.width;
    for (std::size_t i = 0; i < g.size(); ++i) {
        double const radius = g.place[i].radius;
        auto const slice = [&](double position) {
            auto const k = static_cast<std::int64_t>(std::floor((position - origin) / bins.width));
            return static_cast<std::size_t>(std::clamp<std::int64_t>(k, 0, std::ssize(p.mass) - 1));
        };
        std::size_t const first = slice(at[i] - radius), last = slice(at[i] + radius);
        double before = 0.0;
        for (std::size_t k = first; k <= last; ++k) {
            double const begin = origin + static_cast<double>(k) * bins.width, end = begin + bins.width;
            double const until = k == last ? 1.0 : part_before<D>((end - at[i]) / radius);
            p.mass[k] += g.mass[i] * (until - before);
            before = until;
            double const off = std::max({begin - at[i], at[i] - end, 0.0});  // of the slice from the centre
            if (belongs[i] && off < radius)
                p.surface[k] = std::max(p.surface[k], up(g.place[i].centre) + std::sqrt(radius * radius - off * off));
        }
    }
    return p;
}

template Profile profile_of<2>(Grains<2> const&, Bins const&);
template Profile profile_of<3>(Grains<3> const&, Bins const&);

}  // namespace dem
