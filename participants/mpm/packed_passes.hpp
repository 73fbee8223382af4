#pragma once

#include <span>

#include "participants/mpm/field.hpp"
#include "participants/mpm/packed_points.hpp"
#include "participants/mpm/packed_stencil.hpp"

//! The loops of PackedStep over the points of one chunk.
namespace mpm::packed {

//! Planes of a chunk's box: what its points give.
enum Given : std::size_t
{
    g_mass,
    g_px,
    g_py,
    g_fx,
    g_fy,
    g_qx,  //!< momentum again, of the new velocities
    g_qy,
    g_volume,  //!< cells, at their lower left node
    g_value,
    given
};

//! Planes of the nodes.
enum Taken : std::size_t
{
    n_mass,
    n_px,
    n_py,
    n_fx,
    n_fy,
    n_qx,
    n_qy,
    n_volume,
    n_value,
    n_vx,  //!< velocity after forces and walls
    n_vy,
    n_dx,  //!< its change
    n_dy,
    n_bx,  //!< velocity before
    n_by,
    n_ux,  //!< of which strain is the gradient
    n_uy,
    n_mean,
    taken
};

using P = PackedPoints;

//! Volume and volume x value of the cells.
inline void add_to_cells(PackedPoints const& p, std::size_t k, Pack volume, Pack value, Planes const& box)
{
    FourIndices const at = box.at(sluice::packs::below(load(p[P::cx] + k)), sluice::packs::below(load(p[P::cy] + k)));
    Pack const product = volume * value;
    for (int lane = 0; lane < 4; ++lane) {
        box[g_volume][at[lane]] += volume[lane];
        box[g_value][at[lane]] += product[lane];
    }
}
inline Pack of_cells(PackedPoints const& p, std::size_t k, Planes const& nodes)
{
    FourIndices const at = nodes.at(sluice::packs::below(load(p[P::cx] + k)), sluice::packs::below(load(p[P::cy] + k)));
    double const* const mean = nodes[n_mean];
    return Pack{mean[at[0]], mean[at[1]], mean[at[2]], mean[at[3]]};
}

inline void mean_stress_to_cells(PackedPoints const& p, std::size_t begin, std::size_t end, Planes const& box)
{
    for (std::size_t k = begin; k < end; k += 4)
        add_to_cells(p, k, load(p[P::volume] + k) * load(p[P::ratio] + k),
                     all(0.5) * (load(p[P::sxx] + k) + load(p[P::syy] + k)), box);
}

//! Returns the kinetic energy of the points.
template <bool affine, bool shared>
double to_grid(PackedPoints const& p, std::size_t begin, std::size_t end, double half_width, double cell,
               Planes const& box, Planes const& nodes)
{
    Pack kinetic{};
    auto const stride = static_cast<std::size_t>(box.stride);
    for (std::size_t k = begin; k < end; k += 4) {
        AxisWeights const ax(load(p[P::cx] + k), half_width), ay(load(p[P::cy] + k), half_width);
        FourRows const rows(ax);
        Pack const mass = load(p[P::mass] + k), vx = load(p[P::vx] + k), vy = load(p[P::vy] + k);
        kinetic = madd(mass, madd(vx, vx, vy * vy), kinetic);
        Momentum<affine> momentum(ax, ay, mass, vx, vy, load(p[P::lxx] + k), load(p[P::lxy] + k), load(p[P::lyx] + k),
                                  load(p[P::lyy] + k), cell);
        Pack sxx = load(p[P::sxx] + k), syy = load(p[P::syy] + k);
        if constexpr (shared) {
            Pack const shift = of_cells(p, k, nodes) - all(0.5) * (sxx + syy);
            sxx += shift, syy += shift;
        }
        Pack const pull = all(-1 / cell) * load(p[P::volume] + k) * load(p[P::ratio] + k);
        sxx *= pull, syy *= pull;
        Pack const sxy = pull * load(p[P::sxy] + k);
        Pack m[3], xx[3], xy[3], yx[3], yy[3];
        for (int j = 0; j < 3; ++j) {
            m[j] = mass * ay.w[j];
            xx[j] = sxx * ay.w[j], xy[j] = sxy * ay.s[j];
            yx[j] = sxy * ay.w[j], yy[j] = syy * ay.s[j];
        }
        FourIndices const at = box.at(ax.first, ay.first);
        for (int lane = 0; lane < 4; ++lane) {
            double* to = box.data + at[lane];
            Pack const w = rows.w[lane], s = rows.s[lane];
            momentum.add(lane, w, to + g_px * box.plane, to + g_py * box.plane, stride);
            for (int j = 0; j < 3; ++j, to += stride) {
                store(to, madd(w, all(m[j][lane]), load(to)));
                double *fx = to + g_fx * box.plane, *fy = to + g_fy * box.plane;
                store(fx, madd(s, all(xx[j][lane]), madd(w, all(xy[j][lane]), load(fx))));
                store(fy, madd(s, all(yx[j][lane]), madd(w, all(yy[j][lane]), load(fy))));
            }
        }
    }
    return 0.5 * sluice::packs::sum(kinetic);
}

//! Forces on the points, one for each in the order of the state, on the planes of a momentum.
inline void loads_to_grid(PackedPoints const& p, std::span<Vec<2> const> loads, std::size_t begin, std::size_t end,
                          double half_width, double cell, Planes const& box)
{
    for (std::size_t k = begin; k < end; k += 4) {
        AxisWeights const ax(load(p[P::cx] + k), half_width), ay(load(p[P::cy] + k), half_width);
        FourRows const rows(ax);
        Pack x{}, y{};
        for (std::size_t lane = 0; lane < 4 && k + lane < p.size(); ++lane) {
            Vec<2> const& force = loads[static_cast<std::size_t>(p.order()[k + lane])];
            x[lane] = force[0], y[lane] = force[1];
        }
        Momentum<false> const given(ax, ay, all(1), x, y, Pack{}, Pack{}, Pack{}, Pack{}, cell);
        FourIndices const to = box.at(ax.first, ay.first);
        for (int lane = 0; lane < 4; ++lane)
            given.add(lane, rows.w[lane], box[g_qx] + to[lane], box[g_qy] + to[lane],
                      static_cast<std::size_t>(box.stride));
    }
}

//! What a step makes of the points of a chunk.
struct Moved
{
    double kinetic = 0, field = 0;  //!< energy, work [J/m]
    bool inside = true;
};

//! The box in which points may be [m].
struct Room
{
    double low[2], high[2];
};

template <bool affine, bool musl, bool turning>
Moved to_points(PackedPoints& p, std::size_t begin, std::size_t end, Setup<2> const& setup, Field<2> const& field,
                double half_width, double dt, Room const& room, Planes const& box, Planes const& nodes)
{
    Pack kinetic{}, fallen{};
    PackMask inside = all(0) == all(0);
    double const cell = setup.cell;
    auto const stride = static_cast<std::size_t>(nodes.stride), box_stride = static_cast<std::size_t>(box.stride);
    Pack const flip = all(setup.flip), pic = all(1 - setup.flip), per_cell = all(1 / cell), step = all(dt);
    for (std::size_t k = begin; k < end; k += 4) {
        AxisWeights const ax(load(p[P::cx] + k), half_width), ay(load(p[P::cy] + k), half_width);
        FourRows const rows(ax);
        FourIndices const at = nodes.at(ax.first, ay.first);
        constexpr bool slopes = affine || !musl;
        Gathered const x = gather<true, slopes>(nodes[n_vx], at, stride, rows, ay);
        Gathered const y = gather<true, slopes>(nodes[n_vy], at, stride, rows, ay);
        Pack const dx = gather<true, false>(nodes[n_dx], at, stride, rows, ay).value;
        Pack const dy = gather<true, false>(nodes[n_dy], at, stride, rows, ay).value;
        Pack own_x = load(p[P::vx] + k), own_y = load(p[P::vy] + k);
        if constexpr (turning) {
            Pack const c = all(field.turn()(0, 0)), s = all(field.turn()(1, 0)), was_x = own_x;
            own_x = c * was_x - s * own_y, own_y = s * was_x + c * own_y;
        }
        Pack const vx = flip * (own_x + dx) + pic * x.value, vy = flip * (own_y + dy) + pic * y.value;
        Pack const mass = load(p[P::mass] + k);
        store(p[P::vx] + k, vx), store(p[P::vy] + k, vy);
        kinetic = madd(mass, madd(vx, vx, vy * vy), kinetic);
        Pack const px = load(p[P::x] + k) + step * x.value, py = load(p[P::y] + k) + step * y.value;
        Pack fall_x = all(setup.gravity[0]), fall_y = all(setup.gravity[1]);
        if constexpr (turning) {  // of the middle of the way
            Pack const rx = px - all(0.5) * step * x.value - all(field.axis()[0]);
            Pack const ry = py - all(0.5) * step * y.value - all(field.axis()[1]);
            fall_x += all(field.pull()(0, 0)) * rx + all(field.pull()(0, 1)) * ry;
            fall_y += all(field.pull()(1, 0)) * rx + all(field.pull()(1, 1)) * ry;
        }
        fallen = madd(mass * step, madd(fall_x, x.value, fall_y * y.value), fallen);
        store(p[P::x] + k, px), store(p[P::y] + k, py);
        inside &=
            (px >= all(room.low[0])) & (px <= all(room.high[0])) & (py >= all(room.low[1])) & (py <= all(room.high[1]));
        Pack lxx{}, lxy{}, lyx{}, lyy{};
        if constexpr (slopes) {
            lxx = x.along_x * per_cell, lxy = x.along_y * per_cell;
            lyx = y.along_x * per_cell, lyy = y.along_y * per_cell;
            store(p[P::lxx] + k, lxx), store(p[P::lxy] + k, lxy);
            store(p[P::lyx] + k, lyx), store(p[P::lyy] + k, lyy);
        }
        if constexpr (musl) {
            Momentum<affine> const momentum(ax, ay, mass, vx, vy, lxx, lxy, lyx, lyy, cell);
            FourIndices const to = box.at(ax.first, ay.first);
            for (int lane = 0; lane < 4; ++lane)
                momentum.add(lane, rows.w[lane], box[g_qx] + to[lane], box[g_qy] + to[lane], box_stride);
        }
    }
    return {0.5 * sluice::packs::sum(kinetic), sluice::packs::sum(fallen), sluice::packs::bits(inside) == 15U};
}

//! The increment of the deformation gradient, from the nodes' velocities or from the gradients that points have.
template <bool gathered, bool shared>
void gradients(PackedPoints& p, std::size_t begin, std::size_t end, Setup<2> const& setup, double half_width, double dt,
               Planes const& box, Planes const& nodes)
{
    auto const stride = static_cast<std::size_t>(nodes.stride);
    for (std::size_t k = begin; k < end; k += 4) {
        Pack xx, xy, yx, yy;
        if constexpr (gathered) {
            AxisWeights const ax(load(p[P::cx] + k), half_width), ay(load(p[P::cy] + k), half_width);
            FourRows const rows(ax);
            FourIndices const at = nodes.at(ax.first, ay.first);
            Gathered const x = gather<false, true>(nodes[n_ux], at, stride, rows, ay);
            Gathered const y = gather<false, true>(nodes[n_uy], at, stride, rows, ay);
            Pack const step = all(dt / setup.cell);
            xx = step * x.along_x, xy = step * x.along_y, yx = step * y.along_x, yy = step * y.along_y;
        } else {
            Pack const step = all(dt);
            xx = step * load(p[P::lxx] + k), xy = step * load(p[P::lxy] + k);
            yx = step * load(p[P::lyx] + k), yy = step * load(p[P::lyy] + k);
        }
        store(p[P::gxx] + k, xx), store(p[P::gxy] + k, xy), store(p[P::gyx] + k, yx), store(p[P::gyy] + k, yy);
        if constexpr (shared)
            add_to_cells(p, k, load(p[P::volume] + k) * load(p[P::ratio] + k), (all(1) + xx) * (all(1) + yy) - xy * yx,
                         box);
    }
}

}  // namespace mpm::packed
