#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "participants/mpm/node_box.hpp"

namespace mpm {

//! A box of cells in tiles; numbers cells tile by tile. The axis along which there are most tiles comes last: of a run
//! of tiles few have neighbours outside of it.
template <int D>
class Tiles
{
 public:
    //! Cells along an edge of a tile: a chunk of four (eight) points a cell is one (two) of them, and reaches few
    //! nodes.
    static constexpr int edge = D == 2 ? 16 : 4;

    explicit Tiles(NodeBox<D> const& cells);
    double keys() const;  //!< how many there are
    //! Whether to sort so many points by them: not if 32 bits do not count them, or if they are so many more than
    //! points that counting them takes longer than it saves.
    bool serve(std::size_t points) const;
    std::uint32_t key(std::array<int, D> const& cell) const;

 private:
    std::array<int, D> first_{};              //!< cell
    std::array<std::uint32_t, D> tiles_{};    //!< along each axis
    std::array<std::size_t, D> from_last_{};  //!< axes, the one that comes last first
};

//! Where each of a row goes that is put in the order of its keys, of which there are `count`; equal ones keep theirs.
std::vector<std::uint32_t> places_by_key(std::span<std::uint32_t const> keys, std::size_t count);

}  // namespace mpm
