#pragma once

#include <array>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <string>
#include <vector>

#include "participants/lbm/solver.hpp"
#include "tests/support/verification.hpp"

//! What the fluid's verification cases share. They run in lattice units: cell = step = density = 1.
namespace lattice_case {

inline lbm::Config config(std::ptrdiff_t nx, std::ptrdiff_t ny, double tau)
{
    lbm::Config c;
    c.cell = c.step = c.density = 1;
    c.size = {static_cast<double>(nx), static_cast<double>(ny)};
    c.viscosity = (tau - 0.5) / 3;
    return c;
}

inline void make_periodic(lbm::Config& c, bool x, bool y)
{
    c.set_periodic(0, x);
    c.set_periodic(1, y);
}

//! Ways to compute one flow.
struct Variant
{
    lbm::Operator collision = lbm::Operator::mrt;
    lbm::Precision precision = lbm::Precision::float64;
    lbm::Surface surface = lbm::Surface::covered;

    void set(lbm::Config& c) const
    {
        c.collision = collision;
        c.precision = precision;
        c.surface = surface;
    }
};

//! Discs that a case moves by hand.
struct Discs
{
    std::vector<double> position, velocity, spin, radius;

    void add(double x, double y, double r, double ux = 0, double uy = 0, double w = 0)
    {
        position.insert(position.end(), {x, y});
        velocity.insert(velocity.end(), {ux, uy});
        spin.push_back(w);
        radius.push_back(r);
    }
    lbm::BodiesView view() const { return {position, velocity, spin, radius}; }
};

//! Mean of one velocity component over the whole lattice, solids counted as they move.
template <int D>
double mean_velocity(lbm::Solver<D>& solver, std::size_t component)
{
    lbm::Fields const f = solver.fields();
    double sum = 0;
    for (std::size_t k = component; k < f.velocity.size(); k += D) sum += f.velocity[k];
    return sum / static_cast<double>(f.nx * f.ny * f.nz);
}

//! Steps until the limit of `measure()`, taken every `interval` steps, is known to `tolerance` of itself: the slowest
//! mode decays exponentially, so three values give the limit (Aitken), and two such limits must agree. Gives up after
//! `limit` steps and returns what it has.
template <class AnySolver, class Measure>
double run_to_steady(AnySolver& solver, int interval, double tolerance, int limit, Measure&& measure)
{
    double x0 = 0, x1 = 0, x2 = 0, last = 0, extrapolated = 0;
    for (int done = 0; done < limit; done += interval) {
        for (int k = 0; k < interval; ++k) solver.step();
        x0 = x1, x1 = x2, x2 = measure();
        double const d1 = x1 - x0, d2 = x2 - x1;
        last = extrapolated;
        extrapolated = d1 != d2 ? x2 - d2 * d2 / (d2 - d1) : x2;
        bool const settled =
            std::abs(d2) <= std::abs(d1) && std::abs(extrapolated - last) <= tolerance * std::abs(extrapolated);
        if (done > 3 * interval && settled) return extrapolated;
    }
    return extrapolated;
}

inline std::string text(char const* pattern, double a, double b)
{
    char out[80];
    std::snprintf(out, sizeof out, pattern, a, b);
    return out;
}

//! Cases that are run with both, since drag is right to a small part of a cell, or with all.
inline constexpr std::array sharp_surfaces{lbm::Surface::covered, lbm::Surface::interpolated};
inline constexpr std::array all_surfaces{lbm::Surface::covered, lbm::Surface::interpolated, lbm::Surface::forced};

inline std::string of_surface(lbm::Surface surface, std::string const& what)
{
    constexpr std::array names{"", "interpolated, ", "forced, "};
    return names[static_cast<std::size_t>(surface)] + what;
}

inline double relative(double value, double reference)
{
    return std::abs(value / reference - 1);
}

}  // namespace lattice_case
