#pragma once

#include <cmath>
#include <cstring>

//! Four doubles that are computed with at once. GCC and Clang turn these operations into the instructions of the target
//! (AVX2: one each; less: two halves); every lane is rounded as a scalar is.
#pragma GCC diagnostic ignored "-Wpsabi"  // packs stay within a build, all of which has the same instructions
namespace dem {

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

inline Pack either(PackMask mask, Pack yes, Pack no) noexcept
{
    return mask ? yes : no;
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

//! Four vectors of space.
struct PackVec
{
    Pack x, y, z;
};
inline PackVec operator+(PackVec a, PackVec b) noexcept
{
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline PackVec operator-(PackVec a, PackVec b) noexcept
{
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline PackVec operator*(Pack s, PackVec a) noexcept
{
    return {s * a.x, s * a.y, s * a.z};
}
inline Pack dot(PackVec a, PackVec b) noexcept
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline PackVec cross(PackVec a, PackVec b) noexcept
{
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline PackVec along(PackVec velocity, PackVec normal) noexcept
{
    return velocity - dot(velocity, normal) * normal;
}
inline PackVec either(PackMask mask, PackVec yes, PackVec no) noexcept
{
    return {either(mask, yes.x, no.x), either(mask, yes.y, no.y), either(mask, yes.z, no.z)};
}

}  // namespace dem
