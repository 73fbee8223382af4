#pragma once

#include <doctest/doctest.h>

#include <cmath>

#include "participants/mpm/laws.hpp"

//! One element of matter under control.
namespace verification {

//! Plane strain under control: applies the step's strains, with the unknown one such that the stress `held` at (i, i)
//! is kept; by regula falsi, the response is piecewise linear. `also_z`: the same strain across, not plane strain.
template <class Law>
double hold(Law const& law, mpm::Matter& m, mpm::Mat3 const& known, int i, double held, bool also_z = false)
{
    auto const off = [&](double strain, mpm::Matter& out) {
        mpm::Mat3 change = mpm::Mat3::Identity() + known;
        change(i, i) += strain;
        if (also_z) change(2, 2) += strain;
        out = m;
        law.respond(out, mpm::Increment(change));
        return out.stress(i, i) - held;
    };
    mpm::Matter out;
    double a = -0.1, b = 0.1, fa = off(a, out), fb = off(b, out);
    REQUIRE(fa < 0);
    REQUIRE(fb > 0);
    double x = 0;
    for (int k = 0; k < 200; ++k) {
        x = k % 3 == 2 ? 0.5 * (a + b) : (a * fb - b * fa) / (fb - fa);
        double const f = off(x, out);
        if (std::abs(f) < 1e-12 * std::abs(held) || b - a < 1e-17) break;
        (f < 0 ? a : b) = x;
        (f < 0 ? fa : fb) = f;
    }
    m = out;
    return x;
}

inline double relative(double value, double reference)
{
    return std::abs(value / reference - 1);
}

}  // namespace verification
