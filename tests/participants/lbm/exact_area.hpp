#pragma once

#include <algorithm>
#include <array>
#include <cmath>

//! Area of a disc (centre 0, radius r) in the rectangle [x0, x1] x [y0, y1], by integrating the height of the slice
//! over x: independent of the solver's walk along the arc.
inline double exact_area(double x0, double x1, double y0, double y1, double r)
{
    auto const half = [&](double x) { return std::sqrt(std::max(0.0, (r - x) * (r + x))); };
    auto const under = [&](double x) {  // integral of sqrt(r^2 - x^2)
        double const at = std::clamp(x, -r, r);
        return 0.5 * (at * half(at) + r * r * std::atan2(at, half(at)));
    };
    std::array<double, 8> cut = {x0, x1, -r, r, -half(y0), half(y0), -half(y1), half(y1)};
    for (double& c : cut) c = std::clamp(c, x0, x1);
    std::sort(cut.begin(), cut.end());
    double area = 0;
    for (std::size_t k = 0; k + 1 < cut.size(); ++k) {
        double const a = cut[k], b = cut[k + 1], middle = 0.5 * (a + b), s = half(middle);
        if (std::abs(middle) >= r || std::min(y1, s) <= std::max(y0, -s)) continue;
        area += s < y1 ? under(b) - under(a) : y1 * (b - a);
        area -= -s > y0 ? under(a) - under(b) : y0 * (b - a);
    }
    return area;
}
