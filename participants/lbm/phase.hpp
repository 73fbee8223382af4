#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "coupler/base/state.hpp"
#include "coupler/base/team.hpp"
#include "participants/lbm/cell_row.hpp"
#include "participants/lbm/domain.hpp"
#include "participants/lbm/drag_law.hpp"

namespace lbm {

//! Solids finer than a cell, SI: points that stand for some volume of them. Their number may change.
struct PhaseView
{
    std::span<std::int64_t const> id;      //!< names that last
    std::span<double const> position;      //!< [m], shape [point][D]
    std::span<double const> velocity;      //!< [m/s], shape [point][D]
    std::span<double const> solid_volume;  //!< [m3], in the plane [m2]
};

//! What the collision of a row takes of the solids in it; arrays over x (SolidRow).
template <class Stored>
struct SolidRowInput
{
    Stored *fraction, *weight, *open, *ease;
    std::array<Stored*, 3> momentum;
};

//! Solids that are finer than a cell: they hinder the fluid by a law of drag (README.md, Solids that are not resolved).
//! The lattice carries the flux of both, j = rho_0 (n u + (1 - n) v): that is free of sources when the solid moves, and
//! what a partner moves is the mass of a continuum's solid less that of the fluid displaced. Grains have all of theirs.
//!
//! In a step a cell gives up the momentum E (j: after half of the body force, b: velocity of the solid before E, M: the
//! mass that its partner moves, in the cell; r: resistance):
//!     E = r ((j - E/2)/rho - (b + E/M))     hence     E = 2 B (j - rho b),   2 B = r/(1 + r/2 + r/M)
//! In a steady flow that is r times the flux that the lattice has, exactly, for any r; the solid's own answer is
//! implicit, so that neither a bed of low permeability nor dust that follows the fluid at once needs a shorter step.
//! b is the velocity that a point would have without E, were all other forces on it those of the last window; in the
//! cell it is their mean. The points in a cell get E by their solid volume (matter), or each its share of 2 B (j - rho
//! b) with its own b (grains): the sum is E.
//!
//! A point is spread by hat functions of `spread` cells, folded back at walls: their sum is 1.
//!
//! Of several processes each knows all points, and moves those that reach its cells: with what the others found in the
//! cells of theirs that such a point reaches as well. Rows are those of Domain::own().
template <int D>
class Phase
{
 public:
    //! Keeps the domain's address. The whole lattice is one box.
    Phase(Config const& config, Domain<D> const& domain);

    //! Where the points are now; they stay there for `steps` steps, while their velocities follow E and what else acted
    //! on them before. Throws Error (numerical) for what is not finite or has no volume.
    void place(PhaseView const& points, std::int64_t steps);
    //! What the cells get of the points as they are now; before a step's rows collide.
    void spread();

    bool reaches(std::ptrdiff_t row) const { return any_[static_cast<std::size_t>(first_row_ + row)] != 0; }
    //! Marks the blocks of cells of a row with solid.
    void mark(std::ptrdiff_t row, std::vector<char>& blocks) const;
    //! Adds what the cells [begin, end) of a row hold to the row's solids.
    template <class Stored>
    void add_to_row(std::ptrdiff_t row, std::ptrdiff_t begin, std::ptrdiff_t end, Slots<D, Stored> const& slots,
                    Relaxation const& relaxation, SolidRowInput<Stored> const& input);
    //! ... and after the row's collision, what they gave up.
    template <class Stored>
    void take_from_row(std::ptrdiff_t row, std::ptrdiff_t begin, std::ptrdiff_t end, SolidRow<Stored> const& solid);
    //! After all rows: what each point got.
    void gather(sluice::Team& team);

    //! Mean force on each point since place() [N], shape [point][D]; in the plane per metre.
    std::span<double const> force();

    //! B of a cell and the velocity b, for output: in lattice units, j after half of the body force.
    struct Cell
    {
        double solid = 0, weight = 0;
        std::array<double, D> velocity{};
    };
    Cell cell(std::ptrdiff_t row, std::ptrdiff_t x, std::array<double, 3> const& j, double rho) const
    {
        return cell_at(index_of(row, x), j, rho);
    }

    void keep(sluice::State& kept) const;
    //! Throws Error (io) for points that no run has.
    void restore(sluice::State const& kept);

 private:
    using Vector = std::array<double, D>;
    //! Lattice units.
    struct Point
    {
        Vector place{};     //!< cells from the lattice's corner
        double volume = 0;  //!< of solid [cells]
        Vector velocity{};  //!< now
        Vector other{};     //!< by what forces but E change it, in a step
        Vector start{};     //!< velocity when it was placed
        Vector impulse{};   //!< got since then
    };
    static constexpr std::size_t numbers = 1 + 5 * D;  //!< of a point, in a checkpoint

    std::size_t index_of(std::ptrdiff_t row, std::ptrdiff_t x) const
    {
        return static_cast<std::size_t>((first_row_ + row) * cells_[0] + x);
    }
    Cell cell_at(std::size_t index, std::array<double, 3> const& j, double rho) const;
    template <class Each>
    void each_cell(std::size_t point, Each&& each) const;
    void lay_out();
    void find_near();
    std::vector<std::ptrdiff_t> border(int rank) const;
    std::vector<std::size_t> rows_of(std::vector<std::ptrdiff_t> const& layers, int owner) const;
    void swap_borders();
    void share_impulses();
    void require_usable(Point const& point, std::int64_t id) const;
    double mass_of(double volume) const { return volume * inertia_; }

    DragLaw law_;
    double inertia_;  //!< density that the partner moves: of the solid over the fluid's; of a continuum less 1 [-]
    int width_;       //!< cells
    bool matter_;     //!< points are pieces of a continuum
    LatticeUnits unit_;
    std::array<double, 3> origin_;
    Extent cells_;
    std::array<bool, 3> periodic_;
    Domain<D> const& domain_;
    std::ptrdiff_t first_row_;  //!< of this process, in the lattice
    std::vector<std::int64_t> id_;
    std::vector<Point> points_;
    std::int64_t steps_ = 1, gathered_ = 0;  //!< since place() to the next one; until now
    std::vector<std::size_t> near_;          //!< points that reach our cells
    std::vector<std::size_t> rows_;          //!< of the lattice, with solid, that they reach
    //! Rows of ours that another process needs, and of it that we need.
    struct Border
    {
        std::vector<std::size_t> out, in;
    };
    std::vector<Border> borders_;
    std::vector<ranks::Parcel> parcels_;  //!< for each border
    //! Of the hat functions around a point, [point][axis][2 width]: the cell, and the share.
    std::vector<std::int32_t> at_;
    std::vector<double> share_;
    std::vector<double> solid_;  //!< fraction of each cell [-]
    std::vector<double> own_;    //!< B over the weight of the row's solids; then 2 B rho over solid, or 0 (matter)
    std::array<std::vector<double>, D> given_;  //!< to each cell: solid volume times b; then 2 B j, or E, over solid
    std::vector<char> row_blocks_, any_;        //!< with solid: blocks, shape [row][block]; rows
    std::ptrdiff_t blocks_;                     //!< in a row
    std::vector<double> force_;
};

constexpr std::ptrdiff_t block = 8;  //!< cells that go to one kernel or the other together

}  // namespace lbm
