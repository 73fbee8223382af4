#pragma once

#include <cmath>

#include "participants/lbm/cell_row.hpp"

namespace lbm {

//! Collides the cells [begin, end) of one row of D3Q19 in place.
//!
//! By pairs of opposite directions, even part (f_q + f_-q)/2 and odd part (f_q - f_-q)/2 apart: with one rate for each
//! this is TRT (Ginzburg, d'Humieres and Verhaeghe 2008), with equal ones BGK. `split`: the stress has the rate of the
//! viscosity, its trace that of the bulk viscosity, what is left of the even part (three moments of fourth order) a
//! third one: MRT in moments that are orthogonal with the weights w_q (Dellar, Phys. Rev. E 64 (2001) 031203 for
//! D2Q9), in which the stress is projected by w_q 9/2 (c c - I/3). All is f' = f + S - s (f + S/2 - f_eq), S Guo's
//! force, as in the plane (collide_plane.hpp), solids likewise:
//!     even parts relax by (1 - B), odd ones move toward those of u_s by 2 B.
//! Large eddies: tau_eff = (tau + sqrt(tau^2 + 18 sqrt(2) C_s^2 |P|/rho))/2 with P the stress without its trace.
//!
//! Straight-line on purpose, and longer than the house rule: the compiler vectorises it as one loop.
template <Features F>
void collide(Slots<3> const& slots, std::ptrdiff_t begin, std::ptrdiff_t end, Relaxation const& relax,
             SolidRow const& solid)
{
    constexpr bool split = F.les || F.split;
    constexpr double axis = 1.0 / 18, diagonal = 1.0 / 36;
    double *const f0 = slots[0], *const fx = slots[1], *const gx = slots[2], *const fy = slots[3], *const gy = slots[4],
                  *const fz = slots[5], *const gz = slots[6], *const fxy = slots[7], *const gxy = slots[8],
                  *const fyx = slots[9], *const gyx = slots[10], *const fxz = slots[11], *const gxz = slots[12],
                  *const fzx = slots[13], *const gzx = slots[14], *const fyz = slots[15], *const gyz = slots[16],
                  *const fzy = slots[17], *const gzy = slots[18];
    Relaxation const r = relax;
    SolidRow const s = solid;
    double const even_rate = split ? r.square : r.shear, odd_rate = r.flux, tau = r.tau;
    double const eddy_term = r.smagorinsky_term;
    double const Fx = F.force ? r.force[0] : 0.0, Fy = F.force ? r.force[1] : 0.0, Fz = F.force ? r.force[2] : 0.0;
#pragma omp simd
    for (std::ptrdiff_t x = begin; x < end; ++x) {
        double const ex = fx[x] + gx[x], ey = fy[x] + gy[x], ez = fz[x] + gz[x];
        double const exy = fxy[x] + gxy[x], eyx = fyx[x] + gyx[x], exz = fxz[x] + gxz[x], ezx = fzx[x] + gzx[x],
                     eyz = fyz[x] + gyz[x], ezy = fzy[x] + gzy[x];
        double const ox = fx[x] - gx[x], oy = fy[x] - gy[x], oz = fz[x] - gz[x];
        double const oxy = fxy[x] - gxy[x], oyx = fyx[x] - gyx[x], oxz = fxz[x] - gxz[x], ozx = fzx[x] - gzx[x],
                     oyz = fyz[x] - gyz[x], ozy = fzy[x] - gzy[x];
        double const excess = f0[x] + ((ex + ey) + (ez + (exy + eyx))) + ((exz + ezx) + (eyz + ezy));  // rho - 1
        double const rho = 1.0 + excess, inverse_rho = 1.0 / rho;
        double const jx = ox + (oxy + oyx) + (oxz + ozx) + 0.5 * Fx, jy = oy + (oxy - oyx) + (oyz + ozy) + 0.5 * Fy,
                     jz = oz + (oxz - ozx) + (oyz - ozy) + 0.5 * Fz;
        double const ux = jx * inverse_rho, uy = jy * inverse_rho, uz = jz * inverse_rho;

        // even parts: sums of both populations, less equilibrium (f + S/2 - f_eq)
        double const base = madd(-1.5, madd(jx, ux, madd(jy, uy, jz * uz)), excess);
        double const work = F.force ? 3.0 * (ux * Fx + uy * Fy + uz * Fz) : 0.0;  // S = w (9 c.u c.F - work)
        auto const source = [&](double weight, double cu, double cF) { return weight * (9.0 * cu * cF - work); };
        auto const apart = [&](double even, double weight, double cj, double cu, double cF) {
            double const distance = even - 2.0 * weight * madd(4.5 * cj, cu, base);
            return F.force ? distance + source(weight, cu, cF) : distance;
        };
        double const n0 = f0[x] - base * (1.0 / 3) - (F.force ? work * (1.0 / 6) : 0.0);
        double const nx = apart(ex, axis, jx, ux, Fx), ny = apart(ey, axis, jy, uy, Fy),
                     nz = apart(ez, axis, jz, uz, Fz);
        double const nxy = apart(exy, diagonal, jx + jy, ux + uy, Fx + Fy),
                     nyx = apart(eyx, diagonal, jx - jy, ux - uy, Fx - Fy),
                     nxz = apart(exz, diagonal, jx + jz, ux + uz, Fx + Fz),
                     nzx = apart(ezx, diagonal, jx - jz, ux - uz, Fx - Fz),
                     nyz = apart(eyz, diagonal, jy + jz, uy + uz, Fy + Fz),
                     nzy = apart(ezy, diagonal, jy - jz, uy - uz, Fy - Fz);

        double weight2 = 0.0, solid2 = 0.0, fluid = 1.0, rate = 0.0;  // 2 B/eps, 2 B, 1 - B
        double solid_x = 0.0, solid_y = 0.0, solid_z = 0.0;           // 2 B rho u_s
        if constexpr (F.grains) {
            weight2 = 2.0 * s.weight[x];
            solid2 = weight2 * s.fraction[x];
            fluid = madd(-0.5, solid2, 1.0);
            rate = weight2 * rho;
            solid_x = rate * s.momentum[0][x], solid_y = rate * s.momentum[1][x], solid_z = rate * s.momentum[2][x];
            s.force_rate[x] = rate;
            s.force[0][x] = weight2 * jx, s.force[1][x] = weight2 * jy, s.force[2][x] = weight2 * jz;
        }

        // what the stress changes beyond the common rate of the even part
        double along_x = 0.0, along_y = 0.0, along_z = 0.0, shear_xy = 0.0, shear_xz = 0.0, shear_yz = 0.0;
        double bulk = 0.0;
        if constexpr (split) {
            double const xx = nx + (nxy + nyx) + (nxz + nzx), yy = ny + (nxy + nyx) + (nyz + nzy),
                         zz = nz + (nxz + nzx) + (nyz + nzy);
            double const xy = nxy - nyx, xz = nxz - nzx, yz = nyz - nzy;
            double const trace = xx + yy + zz, mean = trace * (1.0 / 3);
            double const dx = xx - mean, dy = yy - mean, dz = zz - mean;
            double shear_rate = r.shear;
            if constexpr (F.les) {
                double const size = madd(dx, dx, madd(dy, dy, dz * dz)) + 2.0 * (xy * xy + xz * xz + yz * yz);
                double const eddy =
                    2.0 / (tau + std::sqrt(madd(eddy_term * inverse_rho, std::sqrt(2.0 * size), tau * tau)));
                if constexpr (F.grains)
                    shear_rate = s.fraction[x] > eddy_free ? shear_rate : eddy;
                else
                    shear_rate = eddy;
            }
            double const more = 4.5 * fluid * (even_rate - shear_rate);
            along_x = more * dx, along_y = more * dy, along_z = more * dz;
            shear_xy = 2.0 * more * xy, shear_xz = 2.0 * more * xz, shear_yz = 2.0 * more * yz;
            bulk = 1.5 * fluid * (even_rate - r.energy) * trace;
        }

        double const even = -0.5 * even_rate * fluid, odd = -odd_rate * fluid;
        f0[x] += 2.0 * even * n0 - (F.force ? work * (1.0 / 3) : 0.0) - (split ? bulk * (1.0 / 3) : 0.0);
        // odd parts: f + S/2 - f_eq; to both populations
        auto const collide_pair = [&](double& one, double& other, double weight, double apart_even, double stress,
                                      double difference, double cj, double cu, double cF, double c_solid) {
            double a = even * apart_even;
            if constexpr (split) a = madd(weight, stress, a);
            if constexpr (F.force) a += source(weight, cu, cF);
            double const held = F.force ? madd(1.5 * weight, cF, 0.5 * difference) : 0.5 * difference;
            double b = odd * madd(-3.0 * weight, cj, held);
            if constexpr (F.force) b = madd(3.0 * weight, cF, b);
            if constexpr (F.grains) b += madd(-solid2, held, 3.0 * weight * c_solid);
            one += a + b;
            other += a - b;
        };
        collide_pair(fx[x], gx[x], axis, nx, along_x, ox, jx, ux, Fx, solid_x);
        collide_pair(fy[x], gy[x], axis, ny, along_y, oy, jy, uy, Fy, solid_y);
        collide_pair(fz[x], gz[x], axis, nz, along_z, oz, jz, uz, Fz, solid_z);
        collide_pair(fxy[x], gxy[x], diagonal, nxy, bulk - along_z + shear_xy, oxy, jx + jy, ux + uy, Fx + Fy,
                     solid_x + solid_y);
        collide_pair(fyx[x], gyx[x], diagonal, nyx, bulk - along_z - shear_xy, oyx, jx - jy, ux - uy, Fx - Fy,
                     solid_x - solid_y);
        collide_pair(fxz[x], gxz[x], diagonal, nxz, bulk - along_y + shear_xz, oxz, jx + jz, ux + uz, Fx + Fz,
                     solid_x + solid_z);
        collide_pair(fzx[x], gzx[x], diagonal, nzx, bulk - along_y - shear_xz, ozx, jx - jz, ux - uz, Fx - Fz,
                     solid_x - solid_z);
        collide_pair(fyz[x], gyz[x], diagonal, nyz, bulk - along_x + shear_yz, oyz, jy + jz, uy + uz, Fy + Fz,
                     solid_y + solid_z);
        collide_pair(fzy[x], gzy[x], diagonal, nzy, bulk - along_x - shear_yz, ozy, jy - jz, uy - uz, Fy - Fz,
                     solid_y - solid_z);
    }
}

}  // namespace lbm
