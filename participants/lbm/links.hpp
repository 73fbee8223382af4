#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "coupler/base/team.hpp"
#include "participants/lbm/coverage.hpp"
#include "participants/lbm/populations.hpp"

namespace lbm {

//! Bodies as surfaces that cut the links between cells: what leaves a cell toward a body comes back from where the link
//! is cut, by central linear interpolation (Ginzburg, Verhaeghe and d'Humieres, Commun. Comput. Phys. 3 (2008) 427).
//! Cells whose centre is in a body are no fluid; one that a body leaves is filled with the body's velocity, and with
//! the density and the stress of the fluid around (README.md, Interpolated surfaces). Lattice units.
template <int D>
class Links
{
 public:
    //! What a body got in a step: the change of momentum of the fluid outside less that of fluid which moves as the
    //! body does and came to lie in it, and the same about its centre.
    using Impulse = std::array<double, D + spins<D>>;

    Links(Extent cells, std::array<bool, 3> periodic);

    //! Where the bodies are in the step that comes, all populations being there. `id`: names that last; a body that was
    //! not there before takes its cells without an impulse. `half_force`: of the body force.
    void place(Populations<D>& populations, std::span<Body<D> const> bodies, std::span<std::uint64_t const> id,
               std::array<double, 3> const& half_force);
    //! The same where the populations are already what they were made by place().
    void restore(std::span<Body<D> const> bodies, std::span<std::uint64_t const> id,
                 std::array<double, 3> const& half_force, std::span<double const> missing);
    //! After streaming, when all else that enters cells has entered.
    void reflect(Populations<D>& populations, std::span<Body<D> const> bodies, sluice::Team& team);

    //! Of each body since place().
    std::vector<Impulse> const& impulses() const noexcept { return impulse_; }
    //! What the fluid would give to a body where cells of other bodies or a wall stand against its own: at rest beside
    //! it, with its mean density, hydrostatic. No fluid loses it.
    std::vector<Impulse> const& pressed() const noexcept { return pressed_; }
    //! Cells within a body, and the sum of their places from its centre.
    std::size_t cells_in(std::size_t body) const noexcept { return count_[body]; }
    std::array<double, D> const& moment_in(std::size_t body) const noexcept { return moment_[body]; }
    //! Of each body: mass by which the fluid outside now has too little, for so many cells within it of density 1. Its
    //! links give it back within some ten steps.
    std::vector<double> const& missing() const noexcept { return missing_; }
    //! Momentum that fluid took along into bodies since place(), as it moves with them: with all impulses what the
    //! fluid outside has lost.
    std::array<double, D> taken_along() const;
    std::size_t bytes() const noexcept { return owner_.size() * sizeof(std::int32_t); }  //!< of all that is large
    bool covers(std::ptrdiff_t row, std::ptrdiff_t x) const noexcept
    {
        return owner_[static_cast<std::size_t>(row * cells_[0] + x)] != nobody;
    }

 private:
    static constexpr std::int32_t nobody = -1, vacated = -2;

    //! Cells of a row that are within one body.
    struct Run
    {
        Extent first;  //!< lowest cell
        std::ptrdiff_t count;
        std::array<double, D> arm;  //!< of its first cell's centre, from the body's
    };
    //! One of them.
    struct Cell
    {
        Extent at;
        std::array<double, D> arm;
    };

    template <class Stored>
    struct Link;

    std::size_t index(Extent const& at) const noexcept
    {
        return static_cast<std::size_t>((at[2] * cells_[1] + at[1]) * cells_[0] + at[0]);
    }
    bool is_fluid(Extent const& at) const noexcept { return owner_[index(at)] == nobody; }
    bool step(Extent& at, std::size_t q) const noexcept;
    std::vector<char> follow(std::span<std::uint64_t const> id);
    void begin(std::size_t bodies, std::array<double, 3> const& half_force);
    void list(std::span<Body<D> const> bodies);
    void list_row(std::int32_t body, Body<D> const& b, Extent at);
    void own(std::int32_t body, Cell const& cell);
    template <class Each>
    static void each_cell(Run const& run, Each&& each);
    template <class Stored>
    double cover(Rows<D, Stored> const& rows, std::size_t i, Body<D> const& body, Cell const& cell);
    template <class Stored>
    double uncover(Rows<D, Stored> const& rows, Body<D> const& body, Cell const& cell);
    double hydrostatic(std::array<double, D> const& arm) const;
    template <class Each>
    void each_link(std::size_t i, Body<D> const& body, Each&& each) const;
    void press(std::size_t i, Body<D> const& body, double excess);
    template <class Stored>
    Link<Stored> find_link(Rows<D, Stored> const& rows, Body<D> const& body, Cell const& cell, std::size_t q,
                           Extent const& x) const;
    template <class Stored>
    double reflect_link(Link<Stored> const& link, std::size_t i, Body<D> const& body, double excess_given);
    template <class Stored>
    void reflect_body(Rows<D, Stored> const& rows, std::size_t i, Body<D> const& body);
    template <class Stored>
    void fill(Rows<D, Stored> const& rows, Body<D> const& body, Run const& run) const;

    Extent cells_;
    std::array<bool, 3> periodic_;
    std::vector<std::int32_t> owner_;             //!< of each cell: a body or nobody
    std::vector<Run> runs_, old_runs_;            //!< by body, and those of the step before
    std::vector<std::size_t> first_, old_first_;  //!< of each body's runs; one more
    std::vector<double> missing_;
    std::vector<std::array<double, D>> moment_;
    std::vector<std::size_t> count_;                      //!< cells of each body
    std::vector<std::pair<std::int32_t, Cell>> entered_;  //!< a body's, which were fluid in the step before
    std::vector<Body<D>> old_bodies_;
    std::vector<std::uint64_t> id_;
    std::vector<Impulse> impulse_, pressed_;
    std::vector<std::array<double, D>> along_;  //!< of each body: momentum that came in with its own velocity
    std::array<double, 3> half_force_{};
    std::array<double, D> given_back_{};  //!< to the fluid, with cells that bodies left
};

}  // namespace lbm
