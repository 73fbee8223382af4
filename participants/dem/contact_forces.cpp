#include "participants/dem/contact_forces.hpp"

#include <cmath>

#include "participants/dem/contact.hpp"
#include "participants/dem/touches.hpp"

namespace dem {
namespace {

//! Ft on the first grain, against the slip. LIGGGHTS leaves the dashpot out while a contact slides: its spring has then
//! been cut to the limit, up to rounding.
template <int D>
Tangent<D> friction_of(Features const& features, ContactLaw const& law, Tangent<D> spring, Tangent<D> dashpot,
                       double normal)
{
    double const limit = law.tangential.friction * std::abs(normal);
    if (features.scheme != Scheme::liggghts) return limited(spring, dashpot, limit).force;
    return norm(spring) < (1.0 - 1e-12) * limit ? spring + dashpot : spring;
}

}  // namespace

template <int D>
std::vector<ContactForce<D>> contact_forces(Setup<D> const& setup, State<D> const& state)
{
    Grains<D> const& g = state.grains;
    Features const& features = setup.features;
    bool const liggghts = features.scheme == Scheme::liggghts;
    auto const& motion = liggghts ? g.half : g.motion;
    std::vector<ContactForce<D>> forces;
    each_touch(setup, state, [&](Touch<D> const& touch) {
        std::size_t const i = touch.first, j = touch.second;
        bool const wall = j >= g.size();
        double const radius = g.place[i].radius, other = wall ? 0.0 : g.place[j].radius;
        auto const& law = wall ? setup.walls[j - g.size()].law : setup.law;
        auto const& history = wall ? state.walls[j - g.size()].history : state.pairs.history;
        Motion<D> partner{};
        if (wall)
            partner.velocity = state.walls[j - g.size()].velocity;
        else
            partner = motion[j];
        if (!wall && features.periodic) partner.velocity += state.cell.images[state.pairs.image[touch.at]].velocity;
        double const distance = (wall ? radius : touch.reach) - touch.overlap;
        Contact<D> c = wall ? contact_with_wall<D>(touch.normal, radius)
                            : contact_of<D>(distance * touch.normal, distance, radius, other);
        if (liggghts) shorten_arms(c, radius, other, touch.overlap);
        double const sqrt_mass = !wall                    ? state.pairs.sqrt_mass[touch.at]
                                 : setup.absolute_damping ? 1.0
                                                          : std::sqrt(g.mass[i]);
        Stiffness const s = stiffness_of(features.elasticity, law, touch.overlap, c.effective);
        ContactForce<D> f{touch.first, touch.second, g.place[i].centre, {}, touch.overlap, 0.0, {}};
        f.end = f.begin - distance * touch.normal;
        f.normal = law.normal.limited(s.force + s.normal * sqrt_mass * c.closing(motion[i], partner));
        if (features.friction)
            f.tangential = -vector_of(friction_of<D>(features, law, history.friction[touch.at],
                                                     s.slip * sqrt_mass * c.slip(motion[i], partner), f.normal),
                                      touch.normal);
        forces.push_back(f);
    });
    return forces;
}

template std::vector<ContactForce<2>> contact_forces<2>(Setup<2> const&, State<2> const&);
template std::vector<ContactForce<3>> contact_forces<3>(Setup<3> const&, State<3> const&);

}  // namespace dem
