#pragma once

#include <array>

#include "participants/mpm/node_box.hpp"
#include "participants/mpm/packed_tensor.hpp"

//! Weights of four points at a time, and what four points give to nodes or take from them: a row of three nodes at
//! once, in a pack whose fourth lane has no weight.
namespace mpm {

typedef int FourIndices __attribute__((vector_size(16)));

template <int D>
inline constexpr int rows_of_nodes = D == 2 ? 3 : 9;  //!< of three, that a point reaches

//! Planes of numbers, one a node, over a box of nodes; x fastest. Rows may be read and written one node beyond.
template <int D>
struct Planes : NodeBox<D>
{
    using NodeBox<D>::first, NodeBox<D>::count, NodeBox<D>::at;
    double* data = nullptr;
    std::size_t plane = 0;  //!< from a plane to the next

    double* operator[](std::size_t k) const { return data + k * plane; }
    FourIndices at(PackVec<D> const& node) const
    {
        Pack place = node[D - 1] - all(first[D - 1]);
        for (int a = D - 2; a >= 0; --a) {
            auto const k = static_cast<std::size_t>(a);
            place = madd(place, all(count[k]), node[a] - all(first[k]));
        }
        return __builtin_convertvector(place, FourIndices);
    }
    //! From the first row of three nodes to the others.
    std::array<std::size_t, rows_of_nodes<D>> rows() const
    {
        auto const stride = static_cast<std::size_t>(count[0]), layer = stride * static_cast<std::size_t>(count[1]);
        std::array<std::size_t, rows_of_nodes<D>> out;
        for (std::size_t r = 0; r < out.size(); ++r) out[r] = r % 3 * stride + r / 3 * layer;
        return out;
    }
};

//! Of all points [cells].
struct Shape
{
    double half_width = 0;
    double radius = 0;  //!< of node 0, of rings
};

//! Of gimp, from a point in cells; a spline is a gimp whose points are a cell wide. Slopes per cell.
struct AxisWeights
{
    Pack first;  //!< lowest of the three nodes
    Pack from;   //!< distance from it, 1/2 to 3/2 [cells]; of rings that of the middle of their mass
    Pack w[3], s[3];

    AxisWeights() = default;
    AxisWeights(Pack place, double half_width) : AxisWeights(place, all(half_width), all(1 / (2 * half_width))) {}
    AxisWeights(Pack place, Pack l, Pack per_width)
    {
        first = sluice::packs::below(place - all(0.5));
        from = place - first;
        Pack const width = l + l, one = all(1), zero{};
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

//! moments_of_hat() of axial.hpp: what radial means add to the weight and slope of a node d cells away.
[[gnu::always_inline]] inline void add_moments(Pack d, Pack l, Pack per_width, Pack per_radius, Pack& weight,
                                               Pack& slope)
{
    using sluice::packs::larger, sluice::packs::smaller;
    Pack const one = all(1), zero{};
    for (int side : {-1, 1}) {
        Pack const rise = all(-side), from = larger(-l, (side < 0 ? -one : zero) - d);
        Pack const to =
            larger(from, smaller(l, (side < 0 ? zero : one) - d));  // nothing where it ends before it begins
        Pack const square = all(0.5) * (to * to - from * from),
                   cube = all(1.0 / 3) * (to * to * to - from * from * from);
        Pack const share = per_width * per_radius;
        weight += share * ((one + rise * d) * square + rise * cube);
        slope += share * rise * square;
    }
}

//! Weights of the nodes of four points: along x as rows of three nodes, one pack a point; across x one pack for each of
//! the rows, one lane a point.
template <int D, bool rings = false>
struct Weights
{
    static constexpr int rows = rows_of_nodes<D>;

    AxisWeights axis[D];
    Pack radius;               //!< of rings [cells]
    Pack hoop[rings ? 4 : 1];  //!< of each point, along x: stretch around the axis [1/cell]
    Pack w[4], s[4];           //!< of each point; slopes along x
    Pack across[rows];         //!< product of the other axes' weights
    Pack slope[D - 1][rows];   //!< its derivatives along the other axes

    [[gnu::always_inline]] Weights(PackVec<D> const& place, Shape const& shape)
    {
        for (int a = rings ? 1 : 0; a < D; ++a) axis[a] = AxisWeights(place[a], shape.half_width);
        if constexpr (rings) turn_around(place[0], shape);
        AxisWeights const& x = axis[0];
        for (int j = 0; j < 3; ++j) w[j] = x.w[j], s[j] = x.s[j];
        w[3] = s[3] = Pack{};
        sluice::packs::transpose(w[0], w[1], w[2], w[3]);
        sluice::packs::transpose(s[0], s[1], s[2], s[3]);
        for (int r = 0; r < rows; ++r) {
            AxisWeights const& y = axis[1];
            across[r] = y.w[r % 3], slope[0][r] = y.s[r % 3];
            if constexpr (D == 3) {
                AxisWeights const& z = axis[2];
                slope[1][r] = across[r] * z.s[r / 3];
                across[r] *= z.w[r / 3], slope[0][r] *= z.w[r / 3];
            }
        }
    }
    PackVec<D> first() const
    {
        PackVec<D> node;
        for (int a = 0; a < D; ++a) node[a] = axis[a].first;
        return node;
    }

 private:
    //! Means over the volume of rings (axial.hpp).
    [[gnu::always_inline]] void turn_around(Pack place, Shape const& shape)
    {
        radius = place + all(shape.radius);
        Pack const l = sluice::packs::smaller(all(shape.half_width), radius), per_width = all(0.5) / l;
        Pack const per_radius = all(1) / radius;
        AxisWeights& x = axis[0];
        x = AxisWeights(place, l, per_width);
        for (int j = 0; j < 3; ++j) {
            hoop[j] = x.w[j] * per_radius;
            add_moments(x.from - all(j), l, per_width, per_radius, x.w[j], x.s[j]);
        }
        hoop[3] = Pack{};
        sluice::packs::transpose(hoop[0], hoop[1], hoop[2], hoop[3]);
        x.from = madd(all(1.0 / 3) * l * l, per_radius, x.from);
    }
};

//! Momentum as it lies on the nodes of a point: m w (v + L (node - place)).
template <int D, bool affine>
struct Momentum
{
    static constexpr int rows = rows_of_nodes<D>;

    Pack start[D][rows];  //!< on the first node of each row, over its weight along x
    Pack along[D][rows];  //!< from node to node

    //! `slope` of the velocity in m/s a cell.
    template <bool rings>
    [[gnu::always_inline]] Momentum(Weights<D, rings> const& weights, Pack mass, PackVec<D> velocity,
                                    PackMat<D> const& slope)
    {
        Pack m[rows];
        for (int r = 0; r < rows; ++r) m[r] = mass * weights.across[r];
        for (int a = 0; a < D; ++a) {
            Pack v = velocity[a];
            if constexpr (affine)
                for (int b = 0; b < D; ++b) v -= slope(a, b) * weights.axis[b].from;
            for (int r = 0; r < rows; ++r) {
                Pack there = v;
                if constexpr (affine) {
                    along[a][r] = m[r] * slope(a, 0);
                    there = madd(all(r % 3), slope(a, 1), there);
                    if constexpr (D == 3) there = madd(all(r / 3), slope(a, 2), there);
                }
                start[a][r] = m[r] * there;
            }
        }
    }

    //! Adds that of point k to the planes of the components, at its first node and the rows from there.
    [[gnu::always_inline]] void add(int k, Pack weights, double* to, std::size_t plane,
                                    std::array<std::size_t, rows> const& offset) const
    {
        Pack const step = weights * Pack{0, 1, 2, 0};
        for (int a = 0; a < D; ++a, to += plane)
            for (int r = 0; r < rows; ++r) {
                double* const at = to + offset[static_cast<std::size_t>(r)];
                Pack sum = madd(weights, all(start[a][r][k]), load(at));
                if constexpr (affine) sum = madd(step, all(along[a][r][k]), sum);
                store(at, sum);
            }
    }
};

//! Sum over the nodes of four points of weight x value; with slopes, of each derivative x value [1/cell].
template <int D>
struct Gathered
{
    Pack value{};
    PackVec<D> slope;
};
template <int D, bool values, bool slopes, bool rings>
[[gnu::always_inline]] inline Gathered<D> gather(double const* plane, FourIndices at,
                                                 std::array<std::size_t, rows_of_nodes<D>> const& offset,
                                                 Weights<D, rings> const& weights)
{
    Pack value[4], along[D][4];
    for (int k = 0; k < 4; ++k) {
        double const* const from = plane + at[k];
        Pack sum{}, across[D - 1]{};
        for (int r = 0; r < rows_of_nodes<D>; ++r) {
            Pack const row = load(from + offset[static_cast<std::size_t>(r)]);
            sum = madd(row, all(weights.across[r][k]), sum);
            if constexpr (slopes)
                for (int b = 0; b < D - 1; ++b) across[b] = madd(row, all(weights.slope[b][r][k]), across[b]);
        }
        if constexpr (values) value[k] = weights.w[k] * sum;
        if constexpr (slopes) {
            along[0][k] = weights.s[k] * sum;
            for (int b = 1; b < D; ++b) along[b][k] = weights.w[k] * across[b - 1];
        }
    }
    Gathered<D> out;
    if constexpr (values) out.value = sluice::packs::sums(value[0], value[1], value[2], value[3]);
    if constexpr (slopes)
        for (int b = 0; b < D; ++b)
            out.slope[b] = sluice::packs::sums(along[b][0], along[b][1], along[b][2], along[b][3]);
    return out;
}

//! Sum of hoop x value: stretch around the axis [1/cell].
[[gnu::always_inline]] inline Pack gather_hoop(double const* plane, FourIndices at,
                                               std::array<std::size_t, rows_of_nodes<2>> const& offset,
                                               Weights<2, true> const& weights)
{
    Pack value[4];
    for (int k = 0; k < 4; ++k) {
        Pack sum{};
        for (int r = 0; r < rows_of_nodes<2>; ++r)
            sum = madd(load(plane + at[k] + offset[static_cast<std::size_t>(r)]), all(weights.across[r][k]), sum);
        value[k] = weights.hoop[k] * sum;
    }
    return sluice::packs::sums(value[0], value[1], value[2], value[3]);
}

}  // namespace mpm
