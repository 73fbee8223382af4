#include "participants/lbm/blow_up.hpp"

namespace lbm {

template <int D, class Stored>
bool has_blown_up(Slots<D, Stored> const& f, std::ptrdiff_t nx) noexcept
{
    using L = Lattice<D>;
    double bad = 0;
#pragma omp simd reduction(+ : bad)
    for (std::ptrdiff_t x = 0; x < nx; ++x) {
        double excess = 0, jx = 0, jy = 0, jz = 0;
#pragma GCC unroll 19
        for (std::size_t q = 0; q < L::directions; ++q) {
            double const value = f[q][x];
            excess += value;
            jx += L::c[q][0] * value;
            jy += L::c[q][1] * value;
            jz += L::c[q][2] * value;
        }
        double const fastest = speed_limit * (1.0 + excess);
        bool const good =
            jx * jx + jy * jy + jz * jz <= fastest * fastest && excess * excess <= excess_limit * excess_limit;
        bad += good ? 0.0 : 1.0;  // a NaN is never good
    }
    return bad > 0;
}
template bool has_blown_up<2>(Slots<2, double> const&, std::ptrdiff_t) noexcept;
template bool has_blown_up<2>(Slots<2, float> const&, std::ptrdiff_t) noexcept;
template bool has_blown_up<3>(Slots<3, double> const&, std::ptrdiff_t) noexcept;
template bool has_blown_up<3>(Slots<3, float> const&, std::ptrdiff_t) noexcept;

}  // namespace lbm
