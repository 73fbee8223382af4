#pragma once

#include <vector>

#include "participants/lbm/domain.hpp"
#include "participants/lbm/populations.hpp"
#include "participants/lbm/walls.hpp"

namespace lbm {

//! Populations on their way from one process's part of a lattice to another's: only those that cross, each once a step.
template <int D>
class Halo
{
 public:
    //! `in`: where they enter this process's part. All processes together.
    Halo(Domain<D> const& domain, std::vector<Crossing> const& in, Precision precision);

    //! Those that have left in a step, after they have streamed.
    void send(Populations<D> const& populations);
    //! Puts those that were sent where they enter; waits for them. Nothing if it has done so.
    void receive(Populations<D>& populations);

    bool enters(std::ptrdiff_t r) const noexcept { return enters_[static_cast<std::size_t>(r)] != 0; }
    //! Rows that some enter.
    std::vector<std::ptrdiff_t> const& rows() const noexcept { return rows_; }

 private:
    //! Side by side along x; `place` is that of the first, as its box counts.
    struct Run
    {
        std::size_t box, direction;
        Extent place;
        std::ptrdiff_t cells;
    };
    //! What goes to and comes from one process.
    struct Border
    {
        std::vector<Run> out, in;
    };

    ranks::Peers& peers_;
    std::vector<Border> borders_;
    std::vector<ranks::Parcel> parcels_;  //!< for each border
    std::vector<char> enters_;            //!< for each row
    std::vector<std::ptrdiff_t> rows_;
    bool under_way_ = false;
};

}  // namespace lbm
