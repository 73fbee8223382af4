#pragma once

#include <cmath>
#include <cstddef>
#include <cstring>
#include <type_traits>
#include <utility>
#if defined(__AVX__)
#include <immintrin.h>
#endif

namespace lbm {

#if defined(__AVX512F__)
inline constexpr std::size_t register_bytes = 64;
#elif defined(__AVX__)
inline constexpr std::size_t register_bytes = 32;
#else
inline constexpr std::size_t register_bytes = 16;
#endif

//! Several floats or doubles that are computed with at once, as many as a register of the target holds. Every lane is
//! rounded as a scalar is, so that a cell's bits do not depend on its place among them. A double takes part as the same
//! number in all lanes.
template <class T>
struct Lanes
{
    using Number = T;
    static constexpr std::size_t count = register_bytes / sizeof(T);
    typedef T Register __attribute__((vector_size(register_bytes)));
    Register all{};

    template <std::size_t N>
    struct Some
    {
        typedef T Type __attribute__((vector_size(N * sizeof(T))));
    };
    template <std::size_t N>
    using Part = typename Some<N>::Type;

    Lanes() = default;
    [[gnu::always_inline]] Lanes(Register r) noexcept : all(r) {}
    //! x - 0, not 0 + x: the compiler may drop the one, since it keeps -0.
    [[gnu::always_inline]] Lanes(double x) noexcept : all(static_cast<T>(x) - Register{}) {}

    [[gnu::always_inline]] friend Lanes operator-(Lanes a) noexcept { return -a.all; }
    [[gnu::always_inline]] friend Lanes operator+(Lanes a, Lanes b) noexcept { return a.all + b.all; }
    [[gnu::always_inline]] friend Lanes operator-(Lanes a, Lanes b) noexcept { return a.all - b.all; }
    [[gnu::always_inline]] friend Lanes operator*(Lanes a, Lanes b) noexcept { return a.all * b.all; }
    [[gnu::always_inline]] friend Lanes operator/(Lanes a, Lanes b) noexcept { return a.all / b.all; }

    //! a b + c, rounded once where the machine can (-ffp-contract=off leaves the choice to the source).
    [[gnu::always_inline]] friend Lanes madd(Lanes a, Lanes b, Lanes c) noexcept
    {
        if constexpr (sizeof(T) == sizeof(double)) {
#if defined(__AVX512F__)
            return Register(_mm512_fmadd_pd(a.all, b.all, c.all));
#elif defined(__FMA__) && defined(__AVX__)
            return Register(_mm256_fmadd_pd(a.all, b.all, c.all));
#endif
        } else {
#if defined(__AVX512F__)
            return Register(_mm512_fmadd_ps(a.all, b.all, c.all));
#elif defined(__FMA__) && defined(__AVX__)
            return Register(_mm256_fmadd_ps(a.all, b.all, c.all));
#endif
        }
        return a.all * b.all + c.all;
    }
    [[gnu::always_inline]] friend Lanes root(Lanes a) noexcept
    {
#if defined(__AVX512F__)
        if constexpr (sizeof(T) == sizeof(double))
            return Register(_mm512_mask_sqrt_pd(a.all, 0xff, a.all));
        else
            return Register(_mm512_mask_sqrt_ps(a.all, 0xffff, a.all));
#else
        for (std::size_t k = 0; k < count; ++k) a.all[k] = std::sqrt(a.all[k]);
        return a;
#endif
    }
    //! a where x is above the limit, else b.
    [[gnu::always_inline]] friend Lanes where_above(Lanes x, double limit, Lanes a, Lanes b) noexcept
    {
        return Register(x.all > Lanes(limit).all ? a.all : b.all);
    }
};

//! The same numbers; the compiler then reads what is used several times from memory once.
template <class T>
[[gnu::always_inline]] inline Lanes<T> in_register(Lanes<T> v) noexcept
{
#if defined(__x86_64__)
    asm("" : "+v"(v.all));
#endif
    return v;
}

//! The numbers from the first one on, by ones.
template <class V>
[[gnu::always_inline]] inline V counted_from(double first) noexcept
{
    V numbers;
    for (std::size_t k = 0; k < V::count; ++k)
        numbers.all[k] = static_cast<decltype(numbers.all[0] + 0)>(first + static_cast<double>(k));
    return numbers;
}

//! Numbers k and k + N/2 of N first, then the same of these sums.
template <std::size_t... K>
[[gnu::always_inline]] inline double sum_of(Lanes<double>::Part<2 * sizeof...(K)> v, std::index_sequence<K...>) noexcept
{
    constexpr int half = sizeof...(K);
    if constexpr (half == 1)
        return v[0] + v[1];
    else
        return sum_of(__builtin_shufflevector(v, v, static_cast<int>(K)...) +
                          __builtin_shufflevector(v, v, static_cast<int>(K) + half...),
                      std::make_index_sequence<half / 2>());
}
[[gnu::always_inline]] inline double sum_of(Lanes<double> v) noexcept
{
    return sum_of(v.all, std::make_index_sequence<Lanes<double>::count / 2>());
}

//! N numbers as another type, rounded to the nearest where it is shorter.
template <class To, std::size_t N, class From>
[[gnu::always_inline]] inline typename Lanes<To>::template Part<N> load_part(From const* from) noexcept
{
    typename Lanes<From>::template Part<N> part;
    std::memcpy(&part, from, sizeof part);
    return __builtin_convertvector(part, typename Lanes<To>::template Part<N>);
}

//! From floats or doubles, and to them: rounded to the nearest where they are shorter.
template <class V, class Stored>
[[gnu::always_inline]] inline V load(Stored const* from) noexcept
{
    typedef Stored Part __attribute__((vector_size(V::count * sizeof(Stored))));
    Part part;
    std::memcpy(&part, from, sizeof part);
    return V(__builtin_convertvector(part, typename V::Register));
}
//! The first `count` lanes of a register, where there is no memory for the others.
template <class T>
class FirstLanes
{
 public:
    explicit FirstLanes(std::ptrdiff_t count) noexcept
    {
#if defined(__AVX512F__)
        among_ = static_cast<Mask>((1U << count) - 1);
#elif defined(__AVX__)
        for (std::size_t k = 0; k < Lanes<T>::count; ++k) among_[k] = static_cast<std::ptrdiff_t>(k) < count ? -1 : 0;
#else
        among_ = count;
#endif
    }
    //! The others are 0.
    [[gnu::always_inline]] Lanes<T> load(T const* from) const noexcept
    {
        using Register = typename Lanes<T>::Register;
#if defined(__AVX512F__)
        if constexpr (sizeof(T) == sizeof(double))
            return Register(_mm512_maskz_loadu_pd(among_, from));
        else
            return Register(_mm512_maskz_loadu_ps(among_, from));
#elif defined(__AVX__)
        if constexpr (sizeof(T) == sizeof(double))
            return Register(_mm256_maskload_pd(from, reinterpret_cast<__m256i>(among_)));
        else
            return Register(_mm256_maskload_ps(from, reinterpret_cast<__m256i>(among_)));
#else
        Register all{};
        for (std::ptrdiff_t k = 0; k < among_; ++k) all[k] = from[k];
        return all;
#endif
    }
    [[gnu::always_inline]] void store(T* to, Lanes<T> const& v) const noexcept
    {
#if defined(__AVX512F__)
        if constexpr (sizeof(T) == sizeof(double))
            _mm512_mask_storeu_pd(to, among_, v.all);
        else
            _mm512_mask_storeu_ps(to, among_, v.all);
#elif defined(__AVX__)
        if constexpr (sizeof(T) == sizeof(double))
            _mm256_maskstore_pd(to, reinterpret_cast<__m256i>(among_), v.all);
        else
            _mm256_maskstore_ps(to, reinterpret_cast<__m256i>(among_), v.all);
#else
        for (std::ptrdiff_t k = 0; k < among_; ++k) to[k] = v.all[k];
#endif
    }

 private:
#if defined(__AVX512F__)
    using Mask = std::conditional_t<sizeof(T) == sizeof(double), __mmask8, __mmask16>;
#elif defined(__AVX__)
    using Mask = decltype(typename Lanes<T>::Register{} < typename Lanes<T>::Register{});
#else
    using Mask = std::ptrdiff_t;
#endif
    Mask among_{};
};

inline constexpr std::ptrdiff_t cache_line = 64;  //!< bytes

//! Asks for a line ahead: many streams are more than the machine follows by itself. Those of the plane have room in the
//! first cache, those of space in the second.
template <int D, class Stored>
[[gnu::always_inline]] inline void ask_ahead(Stored const* at) noexcept
{
    constexpr std::ptrdiff_t lines = D == 2 ? 12 : 24;
    constexpr int first_cache = 3, second_cache = 2;
    __builtin_prefetch(at + lines * cache_line / std::ptrdiff_t{sizeof(Stored)}, 0,
                       D == 2 ? first_cache : second_cache);
}
//! Asks for numbers that will be read soon, from where the machine does not expect it.
template <class T>
inline void prefetch(T const* first, std::ptrdiff_t count) noexcept
{
    auto const* const begin = reinterpret_cast<char const*>(first);
    std::ptrdiff_t const bytes = count * std::ptrdiff_t{sizeof(T)};
    for (std::ptrdiff_t at = 0; at < bytes; at += cache_line) __builtin_prefetch(begin + at);
    __builtin_prefetch(begin + bytes - 1);
}
template <class V, class Stored>
[[gnu::always_inline]] inline void store(Stored* to, V const& v) noexcept
{
    typedef Stored Part __attribute__((vector_size(V::count * sizeof(Stored))));
    Part const part = __builtin_convertvector(v.all, Part);
    std::memcpy(to, &part, sizeof part);
}

}  // namespace lbm
