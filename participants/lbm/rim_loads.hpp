#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "participants/lbm/coverage.hpp"
#include "participants/lbm/domain.hpp"
#include "participants/lbm/populations.hpp"
#include "participants/lbm/walls.hpp"

namespace lbm {

//! What solids at rest get through cells that are not stored. Populations on their way there come back half-way: they
//! give twice their momentum.
template <int D>
class RimLoads
{
 public:
    using Load = std::array<double, D + spins<D>>;  //!< force, and torque about the solid's centre [lattice units]

    using Patches = std::vector<typename Coverage<D>::Kept>;

    //! Keeps the domain's address.
    RimLoads(Domain<D> const& domain, Entrances const& entrances, Patches const& patches);

    //! Of rows that have collided: what they are about to give but at their ends.
    void find(Populations<D> const& populations, std::ptrdiff_t begin, std::ptrdiff_t end);
    //! After the step: the parts of each patch by layers, the first one's sum is number `first`. They do not depend on
    //! how rows are shared among threads and processes.
    void add_parts(Populations<D> const& populations, std::size_t first,
                   std::vector<SumPart<D + spins<D>>>& parts) const;

 private:
    //! Populations of one direction in cells side by side.
    struct Link
    {
        std::uint8_t direction;
        std::int32_t x, cells;
        bool operator==(Link const&) const = default;
    };
    //! What one row gives to a patch, or rows of one layer at their ends. Torque does not depend on where along a link
    //! the force is: that from x to x + c/2 has the same moment as one through x, since c x c = 0.
    struct Rim
    {
        std::int32_t patch;
        bool ends;
        std::ptrdiff_t row, rows;  //!< the first one, and how many
        std::vector<Link> links;
        std::array<double, 3> arm;  //!< from the patch's centre to the first row's cell x = 0
        Load load{};                //!< unless at ends
    };
    class Sum;

    std::vector<Rim> rims_of_row(std::ptrdiff_t r, std::vector<Entrance> const& links, Patches const& patches) const;
    bool is_next(Rim const& rim, Rim const& last) const;

    Domain<D> const& domain_;
    std::vector<Rim> rims_;               //!< by their first row
    std::vector<std::uint32_t> start_{};  //!< for each row, in rims_; and its end
    std::size_t patches_;
};

}  // namespace lbm
