#include "participants/dem/setup.hpp"

#include <algorithm>

namespace dem {

Setup make_setup(Config const& config, Ledger ledger)
{
    ContactConfig const& contact = config.contact;
    Setup setup;
    setup.gravity = (1.0 - config.fluid_density / config.density) * config.gravity;
    setup.normal_force = make_normal_force(contact.normal_stiffness, contact.damping_ratio);
    auto tangential = [&](double friction) {
        return friction > 0.0
                   ? make_tangential_force(contact.tangential_stiffness, contact.tangential_damping, friction)
                   : TangentialForce{};
    };
    setup.tangential_force = tangential(contact.friction);
    setup.features.friction = contact.friction > 0.0;
    setup.features.ledger = ledger == Ledger::on;
    for (WallConfig const& wall : config.walls) {
        setup.walls.push_back({.name = wall.name,
                               .point = wall.point,
                               .normal = wall.normal,
                               .normal_force = setup.normal_force,
                               .tangential_force = tangential(wall.friction),
                               .removed_at = wall.removed_at});
        setup.features.friction = setup.features.friction || wall.friction > 0.0;
    }
    double smallest = config.diameter_min;
    for (GrainConfig const& g : config.grains)
        smallest = smallest > 0.0 ? std::min(smallest, 2.0 * g.radius) : 2.0 * g.radius;
    setup.skin = 0.2 * smallest;  // measured: speed is flat from 0.1 to 0.3 d
    return setup;
}

Solver make_solver(Config const& config, Packing const& packing, Ledger ledger)
{
    Grains grains;
    if (config.column)
        for (std::size_t i = 0; i < packing.radius.size(); ++i)
            grains.add({packing.x[i], packing.y[i]}, packing.radius[i], config.density);
    for (GrainConfig const& g : config.grains) grains.add(g.position, g.radius, config.density, g.velocity, g.spin);
    return Solver(make_setup(config, ledger), std::move(grains), packing.springs);
}

}  // namespace dem
