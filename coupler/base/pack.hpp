#pragma once

#include <cmath>
#include <cstring>
#if defined(__AVX__)
#include <immintrin.h>
#endif

//! Four doubles that are computed with at once. GCC and Clang turn these operations into the instructions of the target
//! (AVX2: one each; less: two halves); every lane is rounded as a scalar is.
#pragma GCC diagnostic ignored "-Wpsabi"  // packs stay within a build, all of which has the same instructions
namespace sluice::packs {

typedef double Pack __attribute__((vector_size(32)));
typedef long long PackMask __attribute__((vector_size(32)));  //!< of a comparison: all bits set, or none

inline Pack all(double x) noexcept
{
    return Pack{x, x, x, x};
}

//! 32 bytes from anywhere.
inline Pack load(double const* from) noexcept
{
    Pack p;
    std::memcpy(&p, from, sizeof p);
    return p;
}
inline void store(double* to, Pack p) noexcept
{
    std::memcpy(to, &p, sizeof p);
}

inline Pack root(Pack p) noexcept
{
    return Pack{std::sqrt(p[0]), std::sqrt(p[1]), std::sqrt(p[2]), std::sqrt(p[3])};
}

//! a b + c, rounded once where the machine can (-ffp-contract=off leaves the choice to the source).
inline Pack madd(Pack a, Pack b, Pack c) noexcept
{
#if defined(__FMA__) && defined(__AVX__)
    return _mm256_fmadd_pd(a, b, c);
#else
    return a * b + c;
#endif
}

//! The whole number below or at each.
inline Pack below(Pack p) noexcept
{
#ifdef __AVX__
    return _mm256_floor_pd(p);
#else
    return Pack{std::floor(p[0]), std::floor(p[1]), std::floor(p[2]), std::floor(p[3])};
#endif
}

inline Pack either(PackMask mask, Pack yes, Pack no) noexcept
{
    return mask ? yes : no;
}
inline Pack larger(Pack a, Pack b) noexcept
{
    return a > b ? a : b;
}
inline Pack smaller(Pack a, Pack b) noexcept
{
    return a < b ? a : b;
}

//! Bit k: the mask of lane k.
inline unsigned bits(PackMask mask) noexcept
{
#ifdef __AVX__
    return static_cast<unsigned>(__builtin_ia32_movmskpd256(reinterpret_cast<Pack>(mask)));
#else
    return static_cast<unsigned>((mask[0] & 1) | (mask[1] & 2) | (mask[2] & 4) | (mask[3] & 8));
#endif
}

//! Rows to columns and back.
inline void transpose(Pack& a, Pack& b, Pack& c, Pack& d) noexcept
{
    Pack const ab0 = __builtin_shuffle(a, b, PackMask{0, 4, 2, 6}), ab1 = __builtin_shuffle(a, b, PackMask{1, 5, 3, 7});
    Pack const cd0 = __builtin_shuffle(c, d, PackMask{0, 4, 2, 6}), cd1 = __builtin_shuffle(c, d, PackMask{1, 5, 3, 7});
    a = __builtin_shuffle(ab0, cd0, PackMask{0, 1, 4, 5});
    b = __builtin_shuffle(ab1, cd1, PackMask{0, 1, 4, 5});
    c = __builtin_shuffle(ab0, cd0, PackMask{2, 3, 6, 7});
    d = __builtin_shuffle(ab1, cd1, PackMask{2, 3, 6, 7});
}

//! The sum of each: of a in lane 0, of b in lane 1, ...
inline Pack sums(Pack a, Pack b, Pack c, Pack d) noexcept
{
    transpose(a, b, c, d);
    return (a + b) + (c + d);
}
inline double sum(Pack a) noexcept
{
    return (a[0] + a[1]) + (a[2] + a[3]);
}

}  // namespace sluice::packs
