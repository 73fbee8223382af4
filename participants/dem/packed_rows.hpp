#pragma once

#include <array>
#include <cstdint>

#include "participants/dem/pack.hpp"
#include "participants/dem/state.hpp"

//! Rows of grains and contacts as columns of four, and back.
namespace dem {

//! Four touching pairs.
using Four = std::array<std::uint32_t, 4>;

//! Four rows as columns.
struct Columns
{
    PackVec vector;
    Pack last;  //!< the fourth number of each row
};
[[gnu::always_inline]] inline Columns columns(double const* a, double const* b, double const* c,
                                              double const* d) noexcept
{
    Pack x = load(a), y = load(b), z = load(c), w = load(d);
    transpose(x, y, z, w);
    return {{x, y, z}, w};
}
template <class Row>
[[gnu::always_inline]] inline Columns columns_of(std::vector<Row> const& rows, Four const& at,
                                                 std::size_t offset = 0) noexcept
{
    auto const from = [&](std::uint32_t k) { return reinterpret_cast<double const*>(&rows[k]) + offset; };
    return columns(from(at[0]), from(at[1]), from(at[2]), from(at[3]));
}
constexpr std::size_t of_spin = 4;  //!< where the spin is in a Motion<3>, the torque in a Load<3> [doubles]

inline PackVec gathered(std::vector<Vec3> const& from, Four const& slot) noexcept
{
    auto const row = [&](std::size_t k) { return Pack{from[slot[k]].x, from[slot[k]].y, from[slot[k]].z, 0.0}; };
    Pack x = row(0), y = row(1), z = row(2), none = row(3);
    transpose(x, y, z, none);
    return {x, y, z};
}
//! Four vectors as rows of 32 bytes; the fourth number is 0.
[[gnu::always_inline]] inline std::array<Pack, 4> rows(PackVec v) noexcept
{
    Pack last{};
    transpose(v.x, v.y, v.z, last);
    return {v.x, v.y, v.z, last};
}

inline void scatter(PackVec v, std::vector<Vec3>& to, Four const& slot) noexcept
{
    auto const r = rows(v);
    for (std::size_t k = 0; k < 4; ++k) to[slot[k]] = {r[k][0], r[k][1], r[k][2]};
}

struct FourPairs
{
    Four slot, i, j;
};

}  // namespace dem
