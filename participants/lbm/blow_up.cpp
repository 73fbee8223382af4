#include "participants/lbm/blow_up.hpp"

namespace lbm {

bool has_blown_up(Slots const& f, std::ptrdiff_t nx) noexcept
{
    double const *const f0 = f[0], *const f1 = f[1], *const f2 = f[2], *const f3 = f[3], *const f4 = f[4],
                        *const f5 = f[5], *const f6 = f[6], *const f7 = f[7], *const f8 = f[8];
    double bad = 0;
#pragma omp simd reduction(+ : bad)
    for (std::ptrdiff_t x = 0; x < nx; ++x) {
        double const right = f1[x] + f5[x] + f8[x], left = f3[x] + f6[x] + f7[x];
        double const jx = right - left, jy = f2[x] + f5[x] + f6[x] - f4[x] - f7[x] - f8[x];
        double const excess = f0[x] + f2[x] + f4[x] + right + left, rho = 1.0 + excess;
        double const fastest = speed_limit * rho;
        bool const good = jx * jx + jy * jy <= fastest * fastest && excess * excess <= excess_limit * excess_limit;
        bad += good ? 0.0 : 1.0;  // a NaN is never good
    }
    return bad > 0;
}

}  // namespace lbm
