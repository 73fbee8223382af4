#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/verification/lbm/lattice_case.hpp"

namespace lattice_case {

struct Point
{
    double place, velocity;
};

//! Interior points of the two lines through the centre: u along x = 1/2, v along y = 1/2, over the lid's speed.
struct Cavity
{
    double reynolds, mark;
    std::vector<Point> u, v;
};

//! Values at k + 1/2 by the cubic through four neighbours; `s` in cells.
template <class Value>
double cubic(double s, std::ptrdiff_t cells, Value value)
{
    auto const first = std::clamp<std::ptrdiff_t>(static_cast<std::ptrdiff_t>(std::floor(s - 0.5)) - 1, 0, cells - 4);
    double sum = 0;
    for (std::ptrdiff_t i = first; i < first + 4; ++i) {
        double weight = 1;
        for (std::ptrdiff_t j = first; j < first + 4; ++j)
            if (j != i) weight *= (s - 0.5 - static_cast<double>(j)) / static_cast<double>(i - j);
        sum += weight * value(i);
    }
    return sum;
}

//! The lid-driven cavity of n cells.
struct Box
{
    std::ptrdiff_t n;
    double lid;  //!< its speed in cells a step
    lbm::Solver<2> solver;

    Box(std::ptrdiff_t cells, double lid_speed, double reynolds, Variant const& variant = {})
        : n(cells), lid(lid_speed), solver(config(cells, lid_speed, reynolds, variant))
    {}
    static lbm::Config config(std::ptrdiff_t n, double lid, double reynolds, Variant const& variant)
    {
        lbm::Config c = lattice_case::config(n, n, 0.5 + 3 * lid * static_cast<double>(n) / reynolds);
        c.walls[lbm::top<2>].velocity[0] = lid;
        variant.set(c);
        return c;
    }

    //! Velocities at the points of the table, over the lid's.
    std::vector<double> at_points(Cavity const& c)
    {
        lbm::Fields const f = solver.fields();
        auto const at = [&](std::ptrdiff_t x, std::ptrdiff_t y, std::size_t axis) {
            return f.velocity[2 * static_cast<std::size_t>(y * n + x) + axis] / lid;
        };
        auto const cells = static_cast<double>(n);
        std::vector<double> values;
        for (Point const& p : c.u)
            values.push_back(cubic(p.place * cells, n, [&](std::ptrdiff_t y) {
                return cubic(0.5 * cells, n, [&](std::ptrdiff_t x) { return at(x, y, 0); });
            }));
        for (Point const& p : c.v)
            values.push_back(cubic(p.place * cells, n, [&](std::ptrdiff_t x) {
                return cubic(0.5 * cells, n, [&](std::ptrdiff_t y) { return at(x, y, 1); });
            }));
        return values;
    }
};

inline double root_mean_square(std::vector<double> const& a, std::vector<double> const& b)
{
    double sum = 0;
    for (std::size_t k = 0; k < a.size(); ++k) sum += (a[k] - b[k]) * (a[k] - b[k]);
    return std::sqrt(sum / static_cast<double>(a.size()));
}

inline std::vector<double> table_of(Cavity const& c)
{
    std::vector<double> values;
    for (auto const* line : {&c.u, &c.v})
        for (Point const& p : *line) values.push_back(p.velocity);
    return values;
}

//! Steps until it is steady; `follow` takes as many. In the mean square, since floats never rest: rounding moves a
//! cell's momentum by some 2^-24 |u|/4 a step, which viscosity spreads to sqrt(ln n/(4 pi nu)) times as much, here 3e-8
//! of the lid's speed with n = 24 to 96 cells, but five to ten times that in the cell that it moves most.
inline void run_until_steady(Box& box, Box* follow = nullptr)
{
    std::vector<double> last;
    double change = 1;
    for (int k = 0; k < 400 && change > 1e-7; ++k) {  // a tenth of what the file asks for, in a quarter of the time
        for (int step = 0; step < 1000; ++step) box.solver.step();
        for (int step = 0; step < 1000 && follow; ++step) follow->solver.step();
        auto const now = box.solver.fields().velocity;
        if (!last.empty()) change = root_mean_square(now, last) / box.lid;
        last = now;
    }
}

//! Root mean square of the distances from the table, over the lid's speed.
inline double cavity_error(Cavity const& c, std::ptrdiff_t n, double lid, Variant const& variant = {})
{
    Box box(n, lid, c.reynolds, variant);
    run_until_steady(box);
    return root_mean_square(box.at_points(c), table_of(c));
}

//! Re = 1000: Botella and Peyret, Comput. Fluids 27 (1998) 421, at the points of Ghia et al. (1982); else Richardson's
//! limit of finite differences for the biharmonic equation, known to 2e-4 (file L04_lid_cavity.csv). Marks: the file's.
inline std::vector<Cavity> cavities()
{
    return {
        {100,
         0.005,
         {{0.0547, -0.03723},
          {0.0625, -0.04197},
          {0.0703, -0.04662},
          {0.1016, -0.06443},
          {0.1719, -0.10174},
          {0.2813, -0.15767},
          {0.4531, -0.21398},
          {0.5, -0.20915},
          {0.6172, -0.1388},
          {0.7344, 0.00419},
          {0.8516, 0.23655},
          {0.9531, 0.69103},
          {0.9609, 0.74047},
          {0.9688, 0.79194},
          {0.9766, 0.84373}},
         {{0.0625, 0.09481},
          {0.0703, 0.10358},
          {0.0781, 0.11175},
          {0.0938, 0.12643},
          {0.1563, 0.16482},
          {0.2266, 0.17936},
          {0.2344, 0.17956},
          {0.5, 0.05754},
          {0.8047, -0.25354},
          {0.8594, -0.23369},
          {0.9063, -0.17708},
          {0.9453, -0.10853},
          {0.9531, -0.09339},
          {0.9609, -0.07798},
          {0.9688, -0.06219}}},
        {400,
         0.006,
         {{0.0547, -0.08182},
          {0.0625, -0.09259},
          {0.0703, -0.1033},
          {0.1016, -0.14618},
          {0.1719, -0.24378},
          {0.2813, -0.32873},
          {0.4531, -0.17148},
          {0.5, -0.11505},
          {0.6172, 0.02104},
          {0.7344, 0.16257},
          {0.8516, 0.29203},
          {0.9531, 0.56156},
          {0.9609, 0.61991},
          {0.9688, 0.6872},
          {0.9766, 0.76067}},
         {{0.0625, 0.18513},
          {0.0703, 0.19879},
          {0.0781, 0.21096},
          {0.0938, 0.23172},
          {0.1563, 0.28354},
          {0.2266, 0.30383},
          {0.2344, 0.30345},
          {0.5, 0.05206},
          {0.8047, -0.38566},
          {0.8594, -0.45384},
          {0.9063, -0.38969},
          {0.9453, -0.23472},
          {0.9531, -0.19821},
          {0.9609, -0.16159},
          {0.9688, -0.12515}}},
        {1000,
         0.01,
         {{0.0547, -0.1812881},
          {0.0625, -0.20233},
          {0.0703, -0.2228955},
          {0.1016, -0.3004561},
          {0.1719, -0.388569},
          {0.2813, -0.2803696},
          {0.4531, -0.1081999},
          {0.5, -0.0620561},
          {0.6172, 0.0570178},
          {0.7344, 0.1886747},
          {0.8516, 0.3372212},
          {0.9531, 0.4723329},
          {0.9609, 0.5169277},
          {0.9688, 0.5808359},
          {0.9766, 0.6644227}},
         {{0.0625, 0.2807056},
          {0.0703, 0.2962703},
          {0.0781, 0.3099097},
          {0.0938, 0.3330442},
          {0.1563, 0.3769189},
          {0.2266, 0.3339924},
          {0.2344, 0.3253592},
          {0.5, 0.0257995},
          {0.8047, -0.3202137},
          {0.8594, -0.4264545},
          {0.9063, -0.5264392},
          {0.9453, -0.4103754},
          {0.9531, -0.3553213},
          {0.9609, -0.2936869},
          {0.9688, -0.2279225}}},
    };
}

}  // namespace lattice_case
