#include "participants/dem/fill.hpp"

#include <cmath>

#include "participants/dem/random.hpp"

namespace dem {
namespace {

std::int64_t cells_along(Config const& config, int axis, double pitch)
{
    if (axis >= config.dimension) return 1;
    return static_cast<std::int64_t>(component(config.periodic.extent, axis) / pitch * (1.0 + 1e-12));
}

}  // namespace

double fill_pitch(Config const& config)
{
    double volume = 1.0;
    for (int k = 0; k < config.dimension; ++k) volume *= component(config.periodic.extent, k);
    double pitch = std::pow(volume / static_cast<double>(config.fill->count), 1.0 / config.dimension);
    auto const fit = [&] {
        return cells_along(config, 0, pitch) * cells_along(config, 1, pitch) * cells_along(config, 2, pitch) >=
               config.fill->count;
    };
    while (!fit()) pitch *= 0.999;
    return pitch;
}

template <int D>
Grains<D> filling(Config const& config)
{
    Random random(config.fill->seed);
    Periodic<3> const& cell = config.periodic;
    double const pitch = fill_pitch(config);
    std::array<std::int64_t, 3> count{1, 1, 1};
    for (int k = 0; k < D; ++k) count[static_cast<std::size_t>(k)] = cells_along(config, k, pitch);
    Grains<D> grains;
    for (std::int64_t n = 0; n < config.fill->count; ++n) {
        std::array<std::int64_t, 3> const at{n % count[0], n / count[0] % count[1], n / count[0] / count[1]};
        double const radius = 0.5 * config.sizes.draw(random);
        Vec<D> centre;
        for (int k = 0; k < D; ++k) {
            auto const axis = static_cast<std::size_t>(k);
            double const edge = component(cell.extent, k) / static_cast<double>(count[axis]);
            component<D>(centre, k) =
                component(cell.low, k) + static_cast<double>(at[axis]) * edge + random.uniform(radius, edge - radius);
        }
        Motion<D> motion{};
        Shear const& shear = cell.shear;
        double const middle = component(cell.low, shear.across) + 0.5 * component(cell.extent, shear.across);
        component<D>(motion.velocity, shear.along) = shear.rate * (component(centre, shear.across) - middle);
        grains.add(centre, radius, config.density, motion);
    }
    return grains;
}

template Grains<2> filling<2>(Config const&);
template Grains<3> filling<3>(Config const&);

}  // namespace dem
