#pragma once

#include <cmath>
#include <cstddef>
#include <cstring>
#if defined(__AVX__)
#include <immintrin.h>
#endif

//! Several doubles that are computed with at once, as many as the target's registers hold. Every lane is rounded as
//! a scalar is, so that a cell's bits do not depend on how many are taken at a time. The same names serve one double.
#pragma GCC diagnostic ignored "-Wpsabi"  // lanes stay within a build, all of which has the same instructions
namespace lbm {

#if defined(__AVX512F__)
inline constexpr std::size_t lane_count = 8;
#elif defined(__AVX__)
inline constexpr std::size_t lane_count = 4;
#else
inline constexpr std::size_t lane_count = 2;
#endif
typedef double Lanes __attribute__((vector_size(8 * lane_count)));

//! The same number in all lanes.
template <class V>
[[gnu::always_inline]] inline V all(double x) noexcept
{
    return V{} + x;
}
//! The numbers from the first one on, by ones.
[[gnu::always_inline]] inline Lanes counted_from(Lanes, double first) noexcept
{
    Lanes all{};
    for (std::size_t k = 0; k < lane_count; ++k) all[k] = first + static_cast<double>(k);
    return all;
}
[[gnu::always_inline]] inline double counted_from(double, double first) noexcept
{
    return first;
}
template <class V>
[[gnu::always_inline]] inline V load(double const* from) noexcept
{
    V v;
    std::memcpy(&v, from, sizeof v);
    return v;
}
template <class V>
[[gnu::always_inline]] inline void store(double* to, V v) noexcept
{
    std::memcpy(to, &v, sizeof v);
}

//! a b + c, rounded once where the machine can (-ffp-contract=off leaves the choice to the source).
[[gnu::always_inline]] inline double madd(double a, double b, double c) noexcept
{
#ifdef __FMA__
    return __builtin_fma(a, b, c);
#else
    return a * b + c;
#endif
}
[[gnu::always_inline]] inline Lanes madd(Lanes a, Lanes b, Lanes c) noexcept
{
#if defined(__AVX512F__)
    return _mm512_fmadd_pd(a, b, c);
#elif defined(__FMA__) && defined(__AVX__)
    return _mm256_fmadd_pd(a, b, c);
#else
    return a * b + c;
#endif
}
[[gnu::always_inline]] inline Lanes madd(double a, Lanes b, Lanes c) noexcept
{
    return madd(all<Lanes>(a), b, c);
}

[[gnu::always_inline]] inline double root(double x) noexcept
{
    return std::sqrt(x);
}
[[gnu::always_inline]] inline Lanes root(Lanes x) noexcept
{
#if defined(__AVX512F__)
    return _mm512_sqrt_pd(x);
#elif defined(__AVX__)
    return _mm256_sqrt_pd(x);
#else
    return Lanes{std::sqrt(x[0]), std::sqrt(x[1])};
#endif
}

}  // namespace lbm
