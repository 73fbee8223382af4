#include "participants/mpm/tiles.hpp"

#include <algorithm>

namespace mpm {
namespace {

constexpr double most_keys_of_a_point = 5000;

}  // namespace

template <int D>
Tiles<D>::Tiles(NodeBox<D> const& cells) : first_(cells.first)
{
    for (std::size_t a = 0; a < D; ++a) {
        tiles_[a] = static_cast<std::uint32_t>((cells.count[a] - 1) / edge + 1);
        from_last_[a] = D - 1 - a;
    }
    auto const most = std::ranges::max_element(from_last_, {}, [&](std::size_t a) { return tiles_[a]; });
    std::rotate(from_last_.begin(), most, most + 1);
}

template <int D>
double Tiles<D>::keys() const
{
    double count = 1;
    for (auto const tiles : tiles_) count *= double(tiles) * edge;
    return count;
}

template <int D>
bool Tiles<D>::serve(std::size_t points) const
{
    return keys() <= std::min(most_keys_of_a_point * static_cast<double>(points), double(UINT32_MAX));
}

template <int D>
std::uint32_t Tiles<D>::key(std::array<int, D> const& cell) const
{
    constexpr std::uint32_t in_tile = D == 2 ? edge * edge : edge * edge * edge;
    std::uint32_t of_tile = 0, within = 0;
    for (std::size_t const a : from_last_)
        of_tile = of_tile * tiles_[a] + static_cast<std::uint32_t>(cell[a] - first_[a]) / edge;
    for (std::size_t a = D; a-- > 0;) within = within * edge + static_cast<std::uint32_t>(cell[a] - first_[a]) % edge;
    return of_tile * in_tile + within;
}

std::vector<std::uint32_t> places_by_key(std::span<std::uint32_t const> keys, std::size_t count)
{
    std::vector<std::uint32_t> next(count + 1, 0), to;
    to.reserve(keys.size());
    for (std::uint32_t const key : keys) ++next[key + 1];
    for (std::size_t k = 1; k <= count; ++k) next[k] += next[k - 1];
    for (std::uint32_t const key : keys) to.push_back(next[key]++);
    return to;
}

template class Tiles<2>;
template class Tiles<3>;

}  // namespace mpm
