#include "participants/dem/setup.hpp"

#include <array>
#include <memory>
#include <utility>
#include <vector>

#include "participants/dem/fill.hpp"

namespace dem {

namespace {

template <int D>
Shape<D> shape_of(WallConfig const& wall)
{
    if (wall.mesh) {
        std::vector<Facet<D>> facets;
        for (auto const& corner : wall.mesh->corner) {
            std::array<Vec<D>, D> own;
            for (std::size_t k = 0; k < D; ++k) own[k] = to_dimension<D>(corner[k]);
            facets.push_back(facet_of(own));
        }
        return Mesh<D>{std::make_shared<FacetTree<D> const>(std::move(facets))};
    }
    Vec<D> const point = to_dimension<D>(wall.point), normal = to_dimension<D>(wall.normal);
    if (wall.radius > 0.0) return Cylinder<D>{point, normal, wall.radius, wall.inside};
    return Plane<D>{point, normal};
}

}  // namespace

template <int D>
Setup<D> make_setup(Config const& config, Ledger ledger)
{
    Setup<D> setup;
    setup.weight = 1.0 - config.fluid_density / config.density;
    setup.gravity = setup.weight * to_dimension<D>(config.gravity);
    setup.first_gravity = setup.weight * to_dimension<D>(config.first_gravity);
    setup.gravity_ramp = config.gravity_ramp;
    if (config.rotation) setup.frame.emplace(*config.rotation);
    setup.law = contact_law(config.contact);
    Features& f = setup.features;
    f.elasticity = config.contact.elasticity;
    f.friction = config.contact.friction > 0.0;
    f.rolling = config.contact.rolling;
    f.scheme = config.scheme;
    f.ledger = ledger == Ledger::on;
    setup.threads = config.threads;
    setup.loads = config.loads;
    for (WallConfig const& wall : config.walls) {
        setup.walls.push_back({.name = wall.name,
                               .shape = shape_of<D>(wall),
                               .motion = motion::converted<Vec<D>>(wall.motion, to_dimension<D>),
                               .law = contact_law(wall.contact),
                               .removed_at = wall.removed_at});
        f.friction = f.friction || wall.contact.friction > 0.0;
    }
    if (f.scheme == Scheme::liggghts) f.friction = true;  // the only variant that is compiled
    setup.lubrication = config.lubrication;
    setup.sleep = config.sleep;
    setup.skin = list_reach(diameters(config).first) + config.lubrication.cutoff;
    f.periodic = config.periodic.any();
    for (std::size_t k = 0; k < D; ++k) setup.periodic.axis[k] = config.periodic.axis[k];
    setup.periodic.low = to_dimension<D>(config.periodic.low);
    setup.periodic.extent = to_dimension<D>(config.periodic.extent);
    setup.periodic.shear = config.periodic.shear;
    return setup;
}

template <int D>
Grains<D> listed_grains(Config const& config)
{
    Grains<D> grains = config.fill ? filling<D>(config) : Grains<D>{};
    for (GrainConfig const& g : config.grains) {
        Motion<D> motion{};
        motion.velocity = to_dimension<D>(g.velocity);
        if constexpr (D == 2)
            motion.spin = g.spin.z;
        else
            motion.spin = g.spin;
        double const density = g.density > 0.0 ? g.density : config.density;
        std::size_t const i = grains.add(to_dimension<D>(g.position), g.radius, density, motion);
        if (g.id >= 0) grains.id[i] = g.id;
    }
    return grains;
}

template <int D>
Solver<D> make_solver(Config const& config, Packing<D> const& packing, Ledger ledger)
{
    Grains<D> grains = listed_grains<D>(config);
    if (config.column)
        for (auto const& [centre, radius] : packing.place) grains.add(centre, radius, config.density);
    return Solver<D>(make_setup<D>(config, ledger), std::move(grains), packing.records);
}

template Grains<2> listed_grains<2>(Config const&);
template Grains<3> listed_grains<3>(Config const&);
template Setup<2> make_setup<2>(Config const&, Ledger);
template Setup<3> make_setup<3>(Config const&, Ledger);
template Solver<2> make_solver<2>(Config const&, Packing<2> const&, Ledger);
template Solver<3> make_solver<3>(Config const&, Packing<3> const&, Ledger);

}  // namespace dem
