#pragma once

#include <array>

#include "coupler/base/pack.hpp"

//! Weights of four points at a time, and what four points give to nodes or take from them: a row of three nodes at
//! once, in a pack whose fourth lane has no weight.
namespace mpm {

using sluice::packs::all;
using sluice::packs::load;
using sluice::packs::madd;
using sluice::packs::Pack;
using sluice::packs::PackMask;
using sluice::packs::store;

typedef int FourIndices __attribute__((vector_size(16)));

//! Planes of numbers, one a node, over a box of nodes; x fastest. Rows may be read and written three nodes beyond.
struct Planes
{
    double* data = nullptr;
    std::size_t plane = 0;  //!< from a plane to the next
    int x0 = 0, y0 = 0;     //!< first node
    int stride = 0, rows = 0;

    double* operator[](std::size_t k) const { return data + k * plane; }
    std::size_t at(int ix, int iy) const
    {
        return static_cast<std::size_t>(iy - y0) * static_cast<std::size_t>(stride) + static_cast<std::size_t>(ix - x0);
    }
    std::array<int, 2> index(std::size_t at) const
    {
        int const n = static_cast<int>(at);
        return {x0 + n % stride, y0 + n / stride};
    }
    FourIndices at(Pack ix, Pack iy) const
    {
        return __builtin_convertvector(madd(iy - all(y0), all(stride), ix - all(x0)), FourIndices);
    }
};

//! Of gimp, from a point in cells; a spline is a gimp whose points are a cell wide. Slopes per cell.
struct AxisWeights
{
    Pack first;  //!< lowest of the three nodes
    Pack from;   //!< distance from it, 1/2 to 3/2 [cells]
    Pack w[3], s[3];

    AxisWeights(Pack place, double half_width)
    {
        first = sluice::packs::below(place - all(0.5));
        from = place - first;
        Pack const l = all(half_width), width = all(2 * half_width), one = all(1), zero{};
        Pack const per_width = all(1 / (2 * half_width));
        auto const outer = [&](Pack distance, Pack& weight, Pack& slope) {
            Pack const in = sluice::packs::smaller(sluice::packs::larger(one + l - distance, zero), width);
            slope = in * per_width;
            weight = madd(all(0.5) * in, slope, sluice::packs::larger(one - l - distance, zero));
        };
        outer(from, w[0], s[0]);
        outer(all(2) - from, w[2], s[2]);
        s[0] = -s[0];
        w[1] = (one - w[0]) - w[2];
        s[1] = -s[0] - s[2];
    }
};

//! Weights along x of each of four points, as rows.
struct FourRows
{
    Pack w[4], s[4];

    explicit FourRows(AxisWeights const& x)
    {
        Pack const zero{};
        w[0] = x.w[0], w[1] = x.w[1], w[2] = x.w[2], w[3] = zero;
        s[0] = x.s[0], s[1] = x.s[1], s[2] = x.s[2], s[3] = zero;
        sluice::packs::transpose(w[0], w[1], w[2], w[3]);
        sluice::packs::transpose(s[0], s[1], s[2], s[3]);
    }
};

//! Momentum as it lies on the nodes of a point: m w (v + L (node - place)).
template <bool affine>
struct Momentum
{
    Pack x[3], y[3];    //!< on the first node of each of the three rows, over its weight along x
    Pack dx[3], dy[3];  //!< from node to node

    Momentum(AxisWeights const& ax, AxisWeights const& ay, Pack mass, Pack vx, Pack vy, Pack lxx, Pack lxy, Pack lyx,
             Pack lyy, double cell)
    {
        if constexpr (affine) {
            Pack const h = all(cell);
            lxx *= h, lxy *= h, lyx *= h, lyy *= h;
            vx -= madd(lxx, ax.from, lxy * ay.from);
            vy -= madd(lyx, ax.from, lyy * ay.from);
        }
        for (int j = 0; j < 3; ++j) {
            Pack const m = mass * ay.w[j];
            x[j] = m * vx, y[j] = m * vy;
            if constexpr (affine) {
                dx[j] = m * lxx, dy[j] = m * lyx;
                vx += lxy, vy += lyy;
            }
        }
    }

    //! Adds that of point k to the rows of px and py.
    [[gnu::always_inline]] void add(int k, Pack weights, double* px, double* py, std::size_t stride) const
    {
        Pack const along = weights * Pack{0, 1, 2, 0};
        for (std::size_t j = 0; j < 3; ++j, px += stride, py += stride) {
            Pack rx = madd(weights, all(x[j][k]), load(px)), ry = madd(weights, all(y[j][k]), load(py));
            if constexpr (affine) {
                rx = madd(along, all(dx[j][k]), rx);
                ry = madd(along, all(dy[j][k]), ry);
            }
            store(px, rx), store(py, ry);
        }
    }
};

//! Sum over the nodes of four points of weight x value; with slopes, of each derivative x value.
struct Gathered
{
    Pack value, along_x, along_y;
};
template <bool values, bool slopes>
[[gnu::always_inline]] inline Gathered gather(double const* plane, FourIndices at, std::size_t stride,
                                              FourRows const& rows, AxisWeights const& y)
{
    Pack value[4], gx[4], gy[4];
    for (int k = 0; k < 4; ++k) {
        double const* from = plane + at[k];
        Pack const r0 = load(from), r1 = load(from + stride), r2 = load(from + 2 * stride);
        Pack const sum = madd(r2, all(y.w[2][k]), madd(r1, all(y.w[1][k]), r0 * all(y.w[0][k])));
        if constexpr (values) value[k] = rows.w[k] * sum;
        if constexpr (slopes) {
            gx[k] = rows.s[k] * sum;
            gy[k] = rows.w[k] * madd(r2, all(y.s[2][k]), madd(r1, all(y.s[1][k]), r0 * all(y.s[0][k])));
        }
    }
    Gathered out{};
    if constexpr (values) out.value = sluice::packs::sums(value[0], value[1], value[2], value[3]);
    if constexpr (slopes) {
        out.along_x = sluice::packs::sums(gx[0], gx[1], gx[2], gx[3]);
        out.along_y = sluice::packs::sums(gy[0], gy[1], gy[2], gy[3]);
    }
    return out;
}

}  // namespace mpm
