#pragma once

#include <cstdint>
#include <vector>

#include "participants/dem/shipment.hpp"
#include "participants/dem/slabs.hpp"

namespace dem {

//! Throws sluice::Error unless the grains of such a run can be shared out: not with sleep or a mesh.
template <int D>
void require_shareable(Setup<D> const& setup);

//! The grains of a run shared out among processes, by slabs that follow them. A process owns the grains of its slab and
//! holds ghosts, copies of those that its own may touch, or an image of which in a periodic cell. Its state has both,
//! in the order of the whole run; a pair of which it owns one grain is computed here and there, from the same numbers,
//! so that no force travels. See README.md.
template <int D>
class Domain
{
 public:
    explicit Domain(ranks::Peers& peers) : peers_(peers) {}

    //! Shares out the state of process 0; those of the others are replaced.
    void distribute(Setup<D> const& setup, State<D>& state);
    //! Whether any process says yes.
    bool any(bool mine) { return sum(mine ? 1.0 : 0.0) > 0.0; }
    //! The sum over all processes, added up by rank.
    double sum(double mine);
    //! The grains to their owners, ghosts anew, slabs anew if they have become uneven; then the lists: rebuild_lists()
    //! of a shared run. Throws as that does.
    void rebuild(Setup<D> const& setup, State<D>& state);
    //! Motion and contact loads of ghosts as their owners have them.
    void refresh(Grains<D>& grains);
    //! What partners do to all grains of the run, in their order, from process 0 to whoever holds them, also as ghosts.
    void deal(std::vector<Load<D>> const& loads, Grains<D>& grains);
    //! Where grains are and how they move, from their owners to process 0, whose `all` has the grains of the run.
    void gather_motion(Grains<D> const& grains, Grains<D>& all);
    //! On process 0 the state of the whole run; elsewhere the same without grains. Sums of the ledger and the forces of
    //! walls are those of all, added up by rank.
    State<D> gather(Setup<D> const& setup, State<D> const& state);

    bool is_first() const { return peers_.rank() == 0; }
    Slabs<D> const& slabs() const { return slabs_; }
    std::int64_t moves() const { return moves_; }                //!< how often slabs were chosen anew
    double smallest_radius() const { return smallest_radius_; }  //!< of all grains of the run [m]

 private:
    void agree(State<D>& state);
    void choose_slabs(State<D> const& state);
    double imbalance(State<D> const& state);
    bool is_uneven(State<D> const& state);
    void ship(Setup<D> const& setup, State<D>& state);
    void lay_borders(Setup<D> const& setup, State<D> const& state);
    template <class Visit>
    void each_viewer(Setup<D> const& setup, State<D> const& state, std::size_t i, Visit&& visit);

    ranks::Peers& peers_;
    Slabs<D> slabs_;
    Census census_;
    std::vector<int> viewers_;            //!< of the grain that is looked at
    std::vector<ranks::Parcel> parcels_;  //!< to and from those that see, or show, grains across a border
    std::vector<std::vector<std::uint32_t>> shown_, seen_;  //!< by parcel: own grains and ghosts, ascending
    double smallest_radius_ = 0.0, largest_radius_ = 0.0;
    double chosen_imbalance_ = 1.0;
    std::int64_t moves_ = 0;
};

}  // namespace dem
