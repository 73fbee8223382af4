#pragma once

#include <cstdint>

#include "participants/dem/random.hpp"
#include "tests/participants/dem/scenes.hpp"

//! Grains in periodic cells.
namespace unit {

constexpr double periodic_step = 2e-6;

template <int D>
dem::Setup<D> cell(dem::Vec<D> extent, double friction = 0.5, bool ledger = false)
{
    dem::ContactConfig c =
        D == 2 ? unit::contact(friction) : unit::rolling_contact(friction, dem::Rolling::elastic_plastic);
    if (D == 3) c.normal_stiffness *= 1e-2, c.tangential_stiffness *= 1e-2;  // spheres are lighter: dt is t_c/37
    dem::Setup<D> s;
    s.law = dem::contact_law(c);
    s.skin = 2e-4;
    s.features = {.friction = true, .rolling = c.rolling, .ledger = ledger, .periodic = true};
    s.periodic.axis.fill(true);
    s.periodic.extent = extent;
    return s;
}

//! A dense, moving gas that fills a cell with `across` cells of 2.1 mm along each axis.
template <int D>
dem::Grains<D> gas(int across, double speed, std::uint64_t seed = 3)
{
    dem::Random random(seed);
    dem::Grains<D> g;
    auto const about = [&](double scale) { return random.uniform(-scale, scale); };
    int const count = D == 2 ? across * across : across * across * across;
    for (int k = 0; k < count; ++k) {
        auto const at = [&](int n) { return (n + 0.5) * 2.1e-3 + about(1e-4); };
        dem::Vec<D> centre;
        dem::Motion<D> motion{};
        centre.x = at(k % across), centre.y = at(k / across % across);
        if constexpr (D == 3) centre.z = at(k / across / across);
        dem::each_number(motion.velocity, [&](double& v) { v = about(speed); });
        dem::each_number(motion.spin, [&](double& v) { v = about(1e3 * speed); });
        g.add(centre, random.uniform(0.8e-3, 1e-3), unit::density, motion);
    }
    return g;
}

template <int D>
dem::Vec<D> cube(int across)
{
    dem::Vec<D> extent;
    for (int k = 0; k < D; ++k) dem::component<D>(extent, k) = across * 2.1e-3;
    return extent;
}

//! A gas that is sheared under a pressure; rows of the flow start at their speeds.
template <int D>
dem::Solver<D> sheared(bool ledger = false, bool plain = false, int threads = 1)
{
    int const across = D == 2 ? 8 : 6;
    dem::Setup<D> s = cell<D>(cube<D>(across), 0.5, ledger);
    s.plain = plain;
    s.threads = threads;
    s.periodic.shear = {.along = 0, .across = 1, .rate = 40.0, .pressure = 2e3, .impedance = 1e5};
    dem::Grains<D> g = gas<D>(across, 0.3);
    for (std::size_t i = 0; i < g.size(); ++i) g.motion[i].velocity.x += 40.0 * g.place[i].centre.y;
    return {s, g};
}

}  // namespace unit
