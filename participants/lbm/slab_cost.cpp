#include "participants/lbm/slab_cost.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace lbm {
namespace {

//! Time for a cell's volume of a body by that for a cell of fluid: of `./dev bench lbm`, 2028 discs of 10 cells in the
//! plane (large eddies), 512 spheres of 6 in space (trt). In single precision fluid takes half the time, interpolated
//! bodies the same, others 0.75 of it.
double times_fluid(Config const& config)
{
    bool const plane = config.dimension == 2, cut = config.surface == Surface::interpolated;
    double const in_doubles = plane ? (cut ? 17 : 5) : (cut ? 33 : 6);
    return config.precision == Precision::float32 ? in_doubles * (cut ? 2 : 1.5) : in_doubles;
}

}  // namespace

template <int D>
std::vector<double> cost_of_bodies(Config const& config, BodiesView const& bodies)
{
    if (bodies.radius.empty()) return {};
    std::ptrdiff_t const layers = config.cells()[D - 1];
    double const factor = times_fluid(config);
    std::vector<double> cost(static_cast<std::size_t>(layers));
    for (std::size_t i = 0; i < bodies.radius.size(); ++i) {
        double const radius = config.hydrodynamic_radius * bodies.radius[i] / config.cell,
                     centre = (bodies.position[D * i + D - 1] - config.origin[D - 1]) / config.cell;
        bool const round = config.periodic(D - 1);
        auto const height = static_cast<double>(layers);
        double const least = round ? centre - height : 0, most = round ? centre + height : height;
        auto const end = static_cast<std::ptrdiff_t>(std::floor(std::min(centre + radius + 0.5, most)));
        for (auto k = static_cast<std::ptrdiff_t>(std::ceil(std::max(centre - radius - 0.5, least))); k < end; ++k) {
            std::ptrdiff_t const layer = round ? wrap(k, layers) : k;
            double const off = static_cast<double>(k) + 0.5 - centre,
                         square = std::max(radius * radius - off * off, 0.0);  // of the section's radius
            cost[static_cast<std::size_t>(layer)] +=
                factor * (D == 2 ? 2 * std::sqrt(square) : std::numbers::pi * square);
        }
    }
    return cost;
}

template std::vector<double> cost_of_bodies<2>(Config const&, BodiesView const&);
template std::vector<double> cost_of_bodies<3>(Config const&, BodiesView const&);

}  // namespace lbm
