#pragma once

#include "coupler/base/pack.hpp"

namespace dem {

using sluice::packs::all;
using sluice::packs::bits;
using sluice::packs::either;
using sluice::packs::load;
using sluice::packs::Pack;
using sluice::packs::PackMask;
using sluice::packs::root;
using sluice::packs::store;
using sluice::packs::transpose;

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
