#include "participants/lbm/blow_up.hpp"

#include "participants/lbm/cell_row.hpp"

namespace lbm {
namespace {

//! Of each lane all bits where the cell is good, else none; a NaN is never good.
template <int D, class V, class Stored>
[[gnu::always_inline]] inline auto good(Slots<D, Stored> const& f, std::ptrdiff_t x) noexcept
{
    V excess;
    std::array<V, D> j;
#pragma GCC unroll 19
    for (std::size_t q = 0; q < Lattice<D>::directions; ++q) {
        V const value = load<V>(f[q] + x);
        ask_ahead<D>(f[q] + x);
        excess = excess + value;
#pragma GCC unroll 3
        for (std::size_t k = 0; k < D; ++k) {
            if (Lattice<D>::c[q][k] > 0) j[k] = j[k] + value;
            if (Lattice<D>::c[q][k] < 0) j[k] = j[k] - value;
        }
    }
    V const fastest = speed_limit * (1.0 + excess);
    V square;
    for (V const& component : j) square = square + component * component;
    return (square.all <= (fastest * fastest).all) & ((excess * excess).all <= V(excess_limit * excess_limit).all);
}

}  // namespace

template <int D, class Stored>
bool has_blown_up(Slots<D, Stored> const& slots, std::ptrdiff_t nx) noexcept
{
    using V = Lanes<double>;
    auto all = V{}.all == V{}.all;
    in_whole_registers<D, false, V>(
        slots, {}, {0, nx},
        [&](Slots<D, Stored> const& f, SolidRow<Stored> const&, CellRows const& cells, std::ptrdiff_t) {
            for (std::ptrdiff_t x = cells.begin; x < cells.end; x += V::count) all &= good<D, V>(f, x);
        });
    for (std::size_t lane = 0; lane < V::count; ++lane)
        if (all[lane] == 0) return true;
    return false;
}
template bool has_blown_up<2>(Slots<2, double> const&, std::ptrdiff_t) noexcept;
template bool has_blown_up<2>(Slots<2, float> const&, std::ptrdiff_t) noexcept;
template bool has_blown_up<3>(Slots<3, double> const&, std::ptrdiff_t) noexcept;
template bool has_blown_up<3>(Slots<3, float> const&, std::ptrdiff_t) noexcept;

}  // namespace lbm
