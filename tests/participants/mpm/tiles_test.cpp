#include "participants/mpm/tiles.hpp"

#include <doctest/doctest.h>

#include <set>

namespace {

//! Numbers of all cells of a box, by their place in it.
template <int D>
std::vector<std::uint32_t> keys_of(mpm::NodeBox<D> const& box)
{
    mpm::Tiles<D> const tiles(box);
    std::vector<std::uint32_t> keys;
    for (std::size_t k = 0; k < box.nodes(); ++k) keys.push_back(tiles.key(box.index(k)));
    for (std::uint32_t const key : keys) CHECK(key < tiles.keys());
    CHECK(std::set(keys.begin(), keys.end()).size() == keys.size());
    return keys;
}

}  // namespace

TEST_CASE("tiles: every cell has a number of its own, tile by tile, the longest axis last")
{
    mpm::NodeBox<2> const wide{{-3, 5}, {50, 20}};  // 4 x 2 tiles
    auto const keys = keys_of(wide);
    CHECK(keys[wide.at({-3, 5})] == 0);
    CHECK(keys[wide.at({-2, 5})] == 1);
    CHECK(keys[wide.at({12, 20})] == 255);
    CHECK(keys[wide.at({-3, 21})] == 256);
    CHECK(keys[wide.at({13, 5})] == 512);
    mpm::NodeBox<2> const square{{0, 0}, {32, 32}};  // rows of tiles
    CHECK(keys_of(square)[square.at({16, 0})] == 256);
    mpm::NodeBox<3> const deep{{0, 0, 0}, {5, 12, 8}};  // 2 x 3 x 2: y last
    auto const in_space = keys_of(deep);
    CHECK(in_space[deep.at({4, 0, 0})] == 64);
    CHECK(in_space[deep.at({0, 0, 4})] == 128);
    CHECK(in_space[deep.at({0, 4, 0})] == 256);
}

TEST_CASE("tiles: points are not sorted by keys that are too many for them, or for their numbers")
{
    CHECK(mpm::Tiles<2>({{0, 0}, {160, 160}}).serve(6));  // 25600
    CHECK(!mpm::Tiles<2>({{0, 0}, {160, 160}}).serve(5));
    CHECK(mpm::Tiles<2>({{0, 0}, {65536, 65520}}).serve(1000000));
    CHECK(!mpm::Tiles<2>({{0, 0}, {65536, 65536}}).serve(1000000));  // 2^32
}

TEST_CASE("tiles: what has the same key keeps its order")
{
    std::vector<std::uint32_t> const keys{2, 0, 2, 3, 0};
    CHECK(mpm::places_by_key(keys, 4) == std::vector<std::uint32_t>{2, 0, 3, 4, 1});
}

TEST_CASE("node_box: what boxes have in common, and what is around them")
{
    using Box = mpm::NodeBox<2>;
    Box const a{{0, 0}, {4, 3}}, b{{2, -1}, {5, 3}}, apart{{4, 0}, {1, 1}};
    auto const both = mpm::common(a, b);
    CHECK(both.first == std::array{2, 0});
    CHECK(both.count == std::array{2, 2});
    CHECK(mpm::common(a, apart).empty());
    CHECK(!mpm::common(a, apart.moved({-1, 0})).empty());
    CHECK((a.has({3, 2}) && !a.has({4, 2}) && !a.has({0, -1})));
    std::vector<Box> const boxes{a, {{100, 100}, {0, 2}}, b};
    auto const all = mpm::around<2>(boxes);
    CHECK(all.first == std::array{0, -1});
    CHECK(all.count == std::array{7, 4});
    CHECK(mpm::around<2>({}).empty());
    std::vector<std::size_t> rows;
    a.each_row(both, [&](std::size_t row, std::size_t length) { rows.insert(rows.end(), {row, length}); });
    CHECK(rows == std::vector<std::size_t>{2, 2, 6, 2});
}
