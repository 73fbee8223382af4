#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "participants/lbm/config.hpp"
#include "participants/lbm/populations.hpp"

namespace lbm {

//! One side in lattice units.
struct Boundary
{
    Border kind = Border::wall;
    //! Of a wall, along itself; of an inflow the largest one, whatever its direction (cells a step).
    std::array<double, 3> velocity{};
    //! Of an inflow, over `velocity`, along each of the other axes at every half cell from the domain's edge on; their
    //! product counts. Empty: 1.
    std::array<std::vector<double>, 3> profile{};
    double ramp = 0;            //!< steps within which an inflow grows from 0
    double share = 1;           //!< of its velocity that an inflow has now
    double density_excess = 0;  //!< rho - 1 at an opening where it is given [-]
    double recall = 0;          //!< of an opening that absorbs sound: how soon it has its density again (1/step)
    //! Of each cell beside such an opening: p - c_s u, u outward, of what comes in; p = (rho - 1) c_s^2.
    std::vector<double> incoming{};
    //! Of the same cells: B of the solids in the last step, and B u_s outward (solid_weight.hpp).
    struct Held
    {
        double share = 0, velocity = 0;
    };
    std::vector<Held> held{};
    //! What enters the cells beside such an opening apart from what left, from when they last had all their
    //! populations; shape [cell][direction].
    std::vector<double> turned{};

    bool rests() const noexcept { return kind == Border::wall && velocity == std::array<double, 3>{}; }
};

//! A cell's place in Boundary::incoming and, its directions side by side, in `turned`.
inline std::size_t place_beside(Extent const& n, std::size_t axis, Extent const& cell) noexcept
{
    auto const [x, y, z] = cell;
    return static_cast<std::size_t>(axis == 0 ? z * n[1] + y : (axis == 1 ? z : y) * n[0] + x);
}

//! Populations of one direction that enter cells side by side in a row from outside of the row's box.
struct Entrance
{
    std::uint8_t into, from;            //!< directions
    std::uint8_t across = 0;            //!< axis of the side that they come from
    Border kind;                        //!< of that side; periodic: they come as they left
    std::int32_t x, cells;              //!< first cell, in the row
    std::int32_t box;                   //!< where they are
    std::array<std::int32_t, 3> place;  //!< of where they are, as that box counts, less the cell's, as its own does
    std::int32_t patch = -1;            //!< the solid, if they come back from cells that are not stored
    double push = 0;                    //!< what a moving wall or the fastest inflow adds [-]
    bool operator==(Entrance const&) const = default;
};

//! Populations of one direction that enter cells side by side in a row from a part of the lattice that another process
//! has.
struct Crossing
{
    std::int32_t row;         //!< of this process
    std::uint8_t into, from;  //!< directions
    std::int32_t x, cells;    //!< first cell, in the row
    std::int32_t box;         //!< of the whole lattice, where they are
    Extent left;              //!< the cell of the lattice that the first of them left; the next ones follow along x
};

//! Of all rows. Most rows have the same links as others.
struct Entrances
{
    std::vector<std::vector<Entrance>> kinds;
    std::vector<std::uint32_t> kind_of;  //!< for each row
    std::vector<Crossing> crossings;     //!< of all rows, by row

    std::vector<Entrance> const& of_row(std::ptrdiff_t r) const { return kinds[kind_of[static_cast<std::size_t>(r)]]; }
};

//! The sides in lattice units.
struct Walls
{
    std::array<std::array<Boundary, 2>, 3> side;  //!< the lower and the upper one along x, y, z
    std::array<double, 3> half_force{};           //!< of the body force, which a cell's velocity contains
    double even_rate = 1;                         //!< of the stress [1/step]
    Entrances entrances{};                        //!< follow from the sides, the boxes and the solids

    std::array<bool, 3> periodic() const
    {
        std::array<bool, 3> all;
        for (std::size_t k = 0; k < 3; ++k) all[k] = side[k][0].kind == Border::periodic;
        return all;
    }
};

//! What links need to know of solids at rest, and of cells that are not stored here.
struct Surroundings
{
    std::function<std::int32_t(Extent const&)> solid_at;   //!< the solid of a cell that is not stored
    std::function<bool(Extent const&)> cover;              //!< whether they cover a cell wholly: sides rest there
    std::function<std::int32_t(Extent const&)> elsewhere;  //!< the whole lattice's box that has a cell; -1: none
};

//! The links of all rows of a layout.
template <int D>
Entrances find_entrances(Walls const& walls, Layout const& layout, Surroundings const& around);

//! Rewrites the populations that enter rows [begin, end) from outside of their box, before they collide, from the one
//! that left into a ghost cell: into that of the box that it left; of one that left a row at its end, from Rows::end.
//! Cells that are not stored throw it back half-way. A wall or an inflow throws it back half-way and adds 6 w_q rho_0
//! c_q.u (Ladd, J. Fluid Mech. 271 (1994) 285), so that what flows in is rho_0 u; a given density throws it back with
//! the other sign and adds twice the even part of the equilibrium of that density and the cell's velocity, and (2 - s)
//! times the even part that is not in equilibrium, the stress (Ginzburg, Verhaeghe and d'Humieres, Commun. Comput.
//! Phys. 3 (2008) 427); a periodic side takes the one that left on the other side. Links through an edge belong to a
//! wall at rest, else to the side across the last axis (top and bottom before the others); a moving wall adds nothing
//! to those through an edge with a wall or a side without friction. Touches slots of those rows alone, and may be
//! repeated until note_turned(). A wall without friction takes the one that left in the mirrored direction.
template <int D, class Stored>
void enter_from_outside(Rows<D, Stored> const& populations, std::ptrdiff_t begin, std::ptrdiff_t end,
                        Walls const& walls);

//! Calls visit(x, place) for the cells of a row that lie beside a side; place: in Boundary::incoming.
template <int D, class Visit>
void each_beside(Layout const& layout, std::ptrdiff_t r, std::size_t axis, bool upper, Visit&& visit)
{
    Extent const& n = layout.cells();
    Row const& row = layout.row(r);
    std::ptrdiff_t const last = upper ? n[axis] - 1 : 0;
    if (axis > 0 && (axis == 1 ? row.y : row.z) != last) return;
    std::ptrdiff_t const from = axis == 0 ? last - row.first : 0, to = axis == 0 ? from + 1 : row.cells;
    if (from < 0 || to > row.cells) return;
    for (std::ptrdiff_t x = from; x < to; ++x) visit(x, place_beside(n, axis, {row.first + x, row.y, row.z}));
}

//! Where what enters a row at one of its ends was noted when it left one, if Entrance::push is all that is added to it;
//! else nullptr. For the next row, if it is alike, it is along_x<D> further.
template <int D, class Stored>
Stored const* comes_from_end(Rows<D, Stored> const& populations, std::ptrdiff_t row, Entrance const& link);

//! Where the populations are that enter a row by a link.
template <int D, class Stored>
Stored const* source(Rows<D, Stored> const& populations, std::ptrdiff_t row, Entrance const& link);

//! enter_from_outside() of one link of one row, from its source().
template <int D, class Stored>
void enter_link(Rows<D, Stored> const& populations, std::ptrdiff_t row, Entrance const& link, Walls const& walls,
                Stored const* out);

//! How a state begins, or goes on, beside openings that absorb sound.
enum class Incoming
{
    found,    //!< as the cells are: nothing is on its way
    kept,     //!< as it stands in Boundary::incoming
    recalled  //!< the same, a step later
};

//! Notes what will enter a row's cells beside openings with a given density, once they have all their populations.
//! Where sound is absorbed that density is the one of what goes out, p + c_s u, and of what comes in, p - c_s u, which
//! returns to the given one by d(p - c_s u)/dt = -recall (p - p_given) (Poinsot and Lele, J. Comput. Phys. 101 (1992)
//! 104).
template <int D, class Stored>
void note_turned(Rows<D, Stored> const& populations, std::ptrdiff_t row, Walls& walls,
                 Incoming incoming = Incoming::recalled);

}  // namespace lbm
