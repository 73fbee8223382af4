#pragma once

#include <cstdint>
#include <vector>

#include "participants/dem/state.hpp"
#include "participants/ranks/peers.hpp"

//! Grains and contacts as rows that travel between processes.
namespace dem {

template <int D>
struct GrainRow
{
    std::uint32_t number = 0;  //!< its index in the run of one process
    std::int32_t owner = 0;    //!< process that it belongs to
    std::int64_t id = 0;
    double mass = 0.0, inertia = 0.0;
    Vec<D> built;
    Place<D> place;
    Motion<D> motion, half;
    Load<D> contact, external;
};

//! A listed contact with its history; not one with a mesh.
template <int D>
struct ContactRow
{
    std::uint32_t first = 0;   //!< number of a grain
    std::uint32_t second = 0;  //!< of a grain > first, or wall index + grains of the run
    std::uint32_t image = 0;   //!< of the second grain, that the pair sees; periodic scenes only
    Tangent<D> friction = {}, rolling = {};

    //! Nothing to remember, not even the sign of a zero.
    bool is_blank() const
    {
        Tangent<D> const none{};
        return std::memcmp(&friction, &none, sizeof none) == 0 && std::memcmp(&rolling, &none, sizeof none) == 0;
    }
};

//! A facet of a mesh near a grain, with its history.
template <int D>
struct FootRow
{
    std::uint32_t grain = 0;  //!< its number
    std::uint32_t wall = 0, facet = 0;
    Foot<D> foot;
    Tangent<D> friction = {}, rolling = {};
};

template <int D>
struct Shipment
{
    std::vector<GrainRow<D>> grains;
    std::vector<ContactRow<D>> contacts;
    std::vector<FootRow<D>> feet;
    std::vector<Crossing<D>> crossings;  //!< `grain`: its number

    ranks::Bytes to_bytes() const;
    //! Adds what to_bytes() made of another one.
    void add(ranks::Bytes const& bytes);
};

//! Who the grains of one process's state are: those it owns, and ghosts.
struct Census
{
    std::size_t all = 0;                  //!< grains of the run
    std::vector<std::uint32_t> number;    //!< by index, ascending
    std::vector<std::int32_t> owner;      //!< by index
    std::vector<std::uint32_t> index_of;  //!< by number; stale for grains that are not here

    //! Index of a grain; number.size(): it is not here.
    std::uint32_t find(std::uint32_t wanted) const
    {
        std::uint32_t const at = index_of[wanted];
        return at < number.size() && number[at] == wanted ? at : static_cast<std::uint32_t>(number.size());
    }
};

template <int D>
GrainRow<D> row_of(State<D> const& state, Census const& census, std::size_t i, std::int32_t owner);

//! Calls `visit(ContactRow, i, j)` for the listed contacts whose first grain is i; j: number of grains here: a wall.
template <int D, class Visit>
void each_contact_row(State<D> const& state, Census const& census, Visit&& visit);

//! Calls `visit(FootRow, i)` for the listed facets of meshes, near grain i.
template <int D, class Visit>
void each_foot_row(State<D> const& state, Census const& census, Visit&& visit);

//! The state's grains, ascending by number, its lists and its crossings, from rows. Those of grains that are not here
//! are left out. What follows from lists (derive_from_list) is not set.
template <int D>
void assemble(Shipment<D> const& rows, Features const& features, State<D>& state, Census& census);

template <class Row, int D>
Row with_history(Row row, History<D> const& history, std::size_t at)
{
    if (!history.friction.empty()) row.friction = history.friction[at];
    if (!history.rolling.empty()) row.rolling = history.rolling[at];
    return row;
}

template <int D, class Visit>
void each_contact_row(State<D> const& state, Census const& census, Visit&& visit)
{
    auto const row = [](std::uint32_t first, std::uint32_t second, History<D> const& history, std::size_t at) {
        return with_history(ContactRow<D>{.first = first, .second = second}, history, at);
    };
    auto const count = static_cast<std::uint32_t>(state.grains.size());
    for (std::uint32_t i = 0; i < count; ++i)
        for (std::uint32_t slot = state.pairs.first[i]; slot < state.pairs.first[i + 1]; ++slot) {
            std::uint32_t const j = state.pairs.other[slot];
            auto pair = row(census.number[i], census.number[j], state.pairs.history, slot);
            if (!state.pairs.image.empty()) pair.image = state.pairs.image[slot];
            visit(pair, i, j);
        }
    for (std::size_t w = 0; w < state.walls.size(); ++w)
        for (std::size_t k = 0; k < state.walls[w].grain.size() && state.walls[w].facet.empty(); ++k) {
            std::uint32_t const i = state.walls[w].grain[k];
            visit(row(census.number[i], static_cast<std::uint32_t>(census.all + w), state.walls[w].history, k), i,
                  count);
        }
}

template <int D, class Visit>
void each_foot_row(State<D> const& state, Census const& census, Visit&& visit)
{
    for (std::uint32_t w = 0; w < state.walls.size(); ++w) {
        WallContacts<D> const& wall = state.walls[w];
        for (std::size_t k = 0; k < wall.facet.size(); ++k)
            visit(
                with_history(
                    FootRow<D>{
                        .grain = census.number[wall.grain[k]], .wall = w, .facet = wall.facet[k], .foot = wall.foot[k]},
                    wall.history, k),
                wall.grain[k]);
    }
}

}  // namespace dem
