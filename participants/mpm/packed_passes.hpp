#pragma once

#include <span>
#include <utility>

#include "participants/mpm/field.hpp"
#include "participants/mpm/packed_points.hpp"
#include "participants/mpm/packed_stencil.hpp"

//! The loops of PackedStep over the points of one chunk.
namespace mpm::packed {

//! Planes of a chunk's box: what its points give. The nodes have the same first, and then more (PackedNodes).
template <int D>
struct Given
{
    enum : std::size_t
    {
        mass = 0,
        momentum,
        force = momentum + D,
        again = force + D,   //!< momentum again, of the new velocities; before that: loads
        volume = again + D,  //!< cells, at their lowest node
        value,
        count
    };
};
template <int D>
struct Taken : Given<D>
{
    enum : std::size_t
    {
        velocity = Given<D>::count,  //!< after forces and walls
        change = velocity + D,       //!< of it
        before = change + D,         //!< velocity before
        strain = before + D,         //!< velocity of which strain is the gradient
        mean = strain + D,           //!< of a cell
        count
    };
};

//! Points from one on to another, whole packs.
struct Range
{
    std::size_t begin = 0, end = 0;
};

template <int D>
[[gnu::always_inline]] inline FourIndices cells_of(PackedPoints<D> const& p, std::size_t k, Planes<D> const& box)
{
    PackVec<D> cell = p.vector_at(PackedColumns<D>::cell, k);
    for (int a = 0; a < D; ++a) cell[a] = sluice::packs::below(cell[a]);
    return box.at(cell);
}
//! Volume and volume x value of the cells.
template <int D>
[[gnu::always_inline]] inline void add_to_cells(PackedPoints<D> const& p, std::size_t k, Pack volume, Pack value,
                                                Planes<D> const& box)
{
    FourIndices const at = cells_of(p, k, box);
    Pack const product = volume * value;
    for (int lane = 0; lane < 4; ++lane) {
        box[Given<D>::volume][at[lane]] += volume[lane];
        box[Given<D>::value][at[lane]] += product[lane];
    }
}
template <int D>
[[gnu::always_inline]] inline Pack of_cells(PackedPoints<D> const& p, std::size_t k, Planes<D> const& nodes)
{
    FourIndices const at = cells_of(p, k, nodes);
    double const* const mean = nodes[Taken<D>::mean];
    return Pack{mean[at[0]], mean[at[1]], mean[at[2]], mean[at[3]]};
}
template <int D>
[[gnu::always_inline]] inline Pack volume_now(PackedPoints<D> const& p, std::size_t k)
{
    return p.at(PackedColumns<D>::volume, k) * p.at(PackedColumns<D>::ratio, k);
}
//! How many axes share the change of volume of a cell.
template <int D, bool rings>
constexpr int shared_axes = rings ? 3 : D;

//! Of those axes.
template <int D, bool rings>
[[gnu::always_inline]] inline Pack mean_of(PackStress<D> const& s)
{
    Pack sum = s(0, 0);
    for (int a = 1; a < shared_axes<D, rings>; ++a) sum += s(a, a);
    return all(1.0 / shared_axes<D, rings>) * sum;
}

template <int D, bool rings>
void mean_stress_to_cells(PackedPoints<D> const& p, Range points, Planes<D> const& box)
{
    for (std::size_t k = points.begin; k < points.end; k += 4)
        add_to_cells(p, k, volume_now(p, k), mean_of<D, rings>(p.stress_at(k)), box);
}

//! In m/s a cell.
template <int D>
[[gnu::always_inline]] inline PackMat<D> slope_in_cells(PackedPoints<D> const& p, std::size_t k, double cell)
{
    PackMat<D> slope = p.matrix_at(PackedColumns<D>::slope, k);
    for (int a = 0; a < D; ++a)
        for (int b = 0; b < D; ++b) slope(a, b) *= all(cell);
    return slope;
}

//! Returns the kinetic energy of the points.
template <int D, bool affine, bool shared, bool rings>
double to_grid(PackedPoints<D> const& p, Range points, Shape const& shape, double cell, Planes<D> const& box,
               Planes<D> const& nodes)
{
    using C = PackedColumns<D>;
    using G = Given<D>;
    constexpr int rows = rows_of_nodes<D>;
    Pack kinetic{};
    auto const offset = box.rows();
    for (std::size_t k = points.begin; k < points.end; k += 4) {
        Weights<D, rings> const weights(p.vector_at(C::cell, k), shape);
        Pack const mass = p.at(C::mass, k);
        PackVec<D> const velocity = p.vector_at(C::velocity, k);
        kinetic = madd(mass, dot(velocity, velocity), kinetic);
        PackMat<D> slope;
        if constexpr (affine) slope = slope_in_cells(p, k, cell);
        Momentum<D, affine> const momentum(weights, mass, velocity, slope);
        PackStress<D> s = p.stress_at(k);
        if constexpr (shared) {
            Pack const shift = of_cells(p, k, nodes) - mean_of<D, rings>(s);
            for (int a = 0; a < shared_axes<D, rings>; ++a) s(a, a) += shift;
        }
        Pack const pull = all(-1 / cell) * volume_now(p, k);
        Pack m[rows], along[D][rows], across[D][rows], around[rows];
        for (int r = 0; r < rows; ++r) m[r] = mass * weights.across[r];
        if constexpr (rings)
            for (int r = 0; r < rows; ++r) around[r] = pull * s(2, 2) * weights.across[r];
        for (int a = 0; a < D; ++a)
            for (int r = 0; r < rows; ++r) {
                along[a][r] = pull * s(0, a) * weights.across[r];
                Pack sum = pull * s(std::min(a, 1), std::max(a, 1)) * weights.slope[0][r];
                if constexpr (D == 3) sum = madd(pull * s(std::min(a, 2), 2), weights.slope[1][r], sum);
                across[a][r] = sum;
            }
        FourIndices const at = box.at(weights.first());
        for (int lane = 0; lane < 4; ++lane) {
            double* const to = box.data + at[lane];
            Pack const w = weights.w[lane], slope_x = weights.s[lane];
            for (int r = 0; r < rows; ++r) {
                double* const there = to + offset[static_cast<std::size_t>(r)];
                store(there, madd(w, all(m[r][lane]), load(there)));
            }
            momentum.add(lane, w, to + G::momentum * box.plane, box.plane, offset);
            for (int a = 0; a < D; ++a) {
                double* const plane = to + (G::force + static_cast<std::size_t>(a)) * box.plane;
                for (int r = 0; r < rows; ++r) {
                    double* const there = plane + offset[static_cast<std::size_t>(r)];
                    Pack sum = madd(w, all(across[a][r][lane]), load(there));
                    if constexpr (rings)
                        if (a == 0) sum = madd(weights.hoop[lane], all(around[r][lane]), sum);
                    store(there, madd(slope_x, all(along[a][r][lane]), sum));
                }
            }
        }
    }
    return 0.5 * sluice::packs::sum(kinetic);
}

//! Forces on the points, one for each in the order of the state, on the planes of a momentum.
template <int D, bool rings>
void loads_to_grid(PackedPoints<D> const& p, std::span<Vec<D> const> loads, Range points, Shape const& shape,
                   Planes<D> const& box)
{
    auto const offset = box.rows();
    for (std::size_t k = points.begin; k < points.end; k += 4) {
        Weights<D, rings> const weights(p.vector_at(PackedColumns<D>::cell, k), shape);
        PackVec<D> force;
        for (std::size_t lane = 0; lane < 4 && k + lane < p.size(); ++lane)
            for (int a = 0; a < D; ++a) force[a][lane] = loads[static_cast<std::size_t>(p.order()[k + lane])][a];
        Momentum<D, false> const given(weights, all(1), force, {});
        FourIndices const to = box.at(weights.first());
        for (int lane = 0; lane < 4; ++lane)
            given.add(lane, weights.w[lane], box[Given<D>::again] + to[lane], box.plane, offset);
    }
}

//! What a step makes of the points of a chunk.
struct Moved
{
    double kinetic = 0, field = 0;  //!< energy, work [J]; plane: per metre
    double round = 0;               //!< work of the field on what went round joined sides [J]
    bool inside = true;
};

//! `room`: lowest and highest corner of where points may be [m].
template <int D, bool affine, bool musl, bool turning, bool rings>
Moved to_points(PackedPoints<D>& p, Range points, Setup<D> const& setup, Field<D> const& field, Shape const& shape,
                double dt, std::pair<Vec<D>, Vec<D>> const& room, Planes<D> const& box, Planes<D> const& nodes)
{
    using C = PackedColumns<D>;
    using T = Taken<D>;
    Pack kinetic{}, fallen{}, rounded{};
    PackMask inside = all(0) == all(0);
    auto const offset = nodes.rows(), box_offset = box.rows();
    Pack const flip = all(setup.flip), pic = all(1 - setup.flip), step = all(dt);
    for (std::size_t k = points.begin; k < points.end; k += 4) {
        Weights<D, rings> const weights(p.vector_at(C::cell, k), shape);
        FourIndices const at = nodes.at(weights.first());
        constexpr bool slopes = affine || !musl;
        PackVec<D> carried, velocity = p.vector_at(C::velocity, k);
        PackMat<D> slope;
        if constexpr (turning) {
            PackVec<D> const was = velocity;
            for (int a = 0; a < D; ++a) {
                velocity[a] = all(field.turn()(a, 0)) * was[0];
                for (int b = 1; b < D; ++b) velocity[a] += all(field.turn()(a, b)) * was[b];
            }
        }
        for (int a = 0; a < D; ++a) {
            auto const plane = static_cast<std::size_t>(a);
            auto const v = gather<D, true, slopes>(nodes[T::velocity + plane], at, offset, weights);
            Pack const change = gather<D, true, false>(nodes[T::change + plane], at, offset, weights).value;
            carried[a] = v.value;
            velocity[a] = flip * (velocity[a] + change) + pic * v.value;
            if constexpr (slopes)
                for (int b = 0; b < D; ++b) slope(a, b) = v.slope[b];
        }
        if constexpr (rings) carried[0] = weights.radius * gather_hoop(nodes[T::velocity], at, offset, weights);
        Pack const mass = p.at(C::mass, k);
        p.set(C::velocity, k, velocity);
        kinetic = madd(mass, dot(velocity, velocity), kinetic);
        PackVec<D> place = p.vector_at(C::place, k), fall;
        for (int a = 0; a < D; ++a) {
            place[a] += step * carried[a];
            if (double const length = setup.period[a]; length > 0) {
                Pack const round = all(-length) * sluice::packs::below((place[a] - all(setup.origin[a])) / all(length));
                place[a] += round;
                rounded -= mass * all(setup.gravity[a]) * round;
            }
            fall[a] = all(setup.gravity[a]);
            inside &= (place[a] >= all(room.first[a])) & (place[a] <= all(room.second[a]));
        }
        if constexpr (turning)  // of the middle of the way
            for (int b = 0; b < D; ++b) {
                Pack const arm = place[b] - all(0.5) * step * carried[b] - all(field.axis()[b]);
                for (int a = 0; a < D; ++a) fall[a] += all(field.pull()(a, b)) * arm;
            }
        fallen = madd(mass * step, dot(fall, carried), fallen);
        p.set(C::place, k, place);
        if constexpr (slopes) {
            PackMat<D> gradient;
            for (int a = 0; a < D; ++a)
                for (int b = 0; b < D; ++b) gradient(a, b) = slope(a, b) * all(1 / setup.cell);
            p.set(C::slope, k, gradient);
        }
        if constexpr (musl) {
            Momentum<D, affine> const momentum(weights, mass, velocity, slope);
            FourIndices const to = box.at(weights.first());
            for (int lane = 0; lane < 4; ++lane)
                momentum.add(lane, weights.w[lane], box[Given<D>::again] + to[lane], box.plane, box_offset);
        }
    }
    return {0.5 * sluice::packs::sum(kinetic), sluice::packs::sum(fallen), sluice::packs::sum(rounded),
            sluice::packs::bits(inside) == 15U};
}

//! The increment of the deformation gradient, from the nodes' velocities or from the gradients that points have.
template <int D, bool gathered, bool shared, bool rings>
void gradients(PackedPoints<D>& p, Range points, Setup<D> const& setup, Shape const& shape, double dt,
               Planes<D> const& box, Planes<D> const& nodes)
{
    using C = PackedColumns<D>;
    auto const offset = nodes.rows();
    for (std::size_t k = points.begin; k < points.end; k += 4) {
        PackMat<D> change;
        if constexpr (gathered) {
            Weights<D, rings> const weights(p.vector_at(C::cell, k), shape);
            FourIndices const at = nodes.at(weights.first());
            if constexpr (rings)
                p.set(C::hoop, k, all(dt / setup.cell) * gather_hoop(nodes[Taken<D>::strain], at, offset, weights));
            for (int a = 0; a < D; ++a) {
                auto const plane = Taken<D>::strain + static_cast<std::size_t>(a);
                auto const u = gather<D, false, true>(nodes[plane], at, offset, weights);
                for (int b = 0; b < D; ++b) change(a, b) = all(dt / setup.cell) * u.slope[b];
            }
        } else {
            change = p.matrix_at(C::slope, k);
            for (int a = 0; a < D; ++a)
                for (int b = 0; b < D; ++b) change(a, b) *= all(dt);
        }
        p.set(C::change, k, change);
        if constexpr (shared) {
            Pack volume = determinant(one_plus(change, all(1)));
            if constexpr (rings) volume *= all(1) + p.at(C::hoop, k);
            add_to_cells(p, k, volume_now(p, k), volume, box);
        }
    }
}

}  // namespace mpm::packed
