#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <unordered_map>
#include <vector>

#include "coupler/base/team.hpp"
#include "participants/lbm/body_cells.hpp"
#include "participants/lbm/populations.hpp"

namespace lbm {

//! Bodies as surfaces that cut the links between cells: what leaves a cell toward a body comes back from where the link
//! is cut, by central linear interpolation (Ginzburg, Verhaeghe and d'Humieres, Commun. Comput. Phys. 3 (2008) 427).
//! Cells whose centre is in a body are no fluid; one that a body leaves is filled with the body's velocity, and with
//! the density and the stress of the fluid around (README.md, Interpolated surfaces). Lattice units. Of a shared
//! lattice each process has the links that come from its own cells, and all know what the bodies got; all make the same
//! calls.
template <int D>
class Links
{
 public:
    //! What a body got in a step: the change of momentum of the fluid outside less that of fluid which moves as the
    //! body does and came to lie in it, and the same about its centre.
    using Impulse = std::array<double, D + spins<D>>;

    //! Keeps the domain's address.
    Links(Domain<D> const& domain, std::array<bool, 3> periodic) : domain_(domain), cells_(domain, periodic) {}

    //! Where the bodies are in the step that comes, all populations being there. `id`: names that last; a body that was
    //! not there before takes its cells without an impulse. `half_force`: of the body force.
    void place(Populations<D>& populations, std::span<Body<D> const> bodies, std::span<std::uint64_t const> id,
               std::array<double, 3> const& half_force);
    //! The same where the populations are already what they were made by place().
    void restore(std::span<Body<D> const> bodies, std::span<std::uint64_t const> id,
                 std::array<double, 3> const& half_force, std::span<double const> missing);
    //! After streaming, when all else that enters cells has entered.
    void reflect(Populations<D>& populations, std::span<Body<D> const> bodies, sluice::Team& team);

    //! Of each body since place(); known after reflect().
    std::vector<Impulse> const& impulses() const noexcept { return impulse_; }
    //! What the fluid would give to a body where cells of other bodies or a wall stand against its own: at rest beside
    //! it, with its mean density, hydrostatic. No fluid loses it.
    std::vector<Impulse> const& pressed() const noexcept { return pressed_; }
    //! Cells within a body, and the sum of their places from its centre.
    double cells_in(std::size_t body) const noexcept { return sums_[body].cells; }
    std::array<double, D> const& moment_in(std::size_t body) const noexcept { return sums_[body].moment; }
    //! Of this process's cells those within bodies.
    std::size_t cells_here() const noexcept { return cells_.count_here(); }
    //! Of each body: mass by which the fluid outside now has too little, for so many cells within it of density 1. Its
    //! links give it back within some ten steps.
    std::vector<double> const& missing() const noexcept { return missing_; }
    //! Momentum that fluid took along into bodies since place(), as it moves with them: with all impulses what the
    //! fluid outside has lost.
    std::array<double, D> taken_along() const;
    std::size_t bytes() const noexcept { return cells_.bytes(); }  //!< of all that is large
    bool covers(std::ptrdiff_t row, std::ptrdiff_t x) const noexcept { return cells_.covers(row, x); }

 private:
    using Cells = BodyCells<D>;
    using Cell = typename Cells::Cell;
    using Run = typename Cells::Run;
    using CellPopulations = std::array<double, Lattice<D>::directions>;

    template <class Stored>
    struct Link;

    //! Where a link comes from.
    struct Source
    {
        Extent at;
        std::ptrdiff_t layer;      //!< of the cell that it leads to, if it comes from outside of the domain
        bool fluid, fluid_behind;  //!< behind: in the cell further back; asked if the first one is
    };
    //! A cell that a body has come to lie on, and what it gives to the body.
    struct Taken
    {
        std::int32_t body;
        Cell cell;
        std::array<double, D> momentum, along;
    };
    //! What reflect() sums up of a body: by layers of the cells that links come from, then over layers.
    struct Sums
    {
        Impulse impulse{};
        std::array<double, D> along{};  //!< momentum that came in with the body's own velocity
        double missing = 0;             //!< mass that came in less what came back
        double excess = 0, links = 0;   //!< density excess of the fluid beside it, at the body's centre; how many
        Impulse still{}, per_excess{};  //!< pressed() without that excess, and for each of its mean
        double cells = 0;
        std::array<double, D> moment{};
    };
    static constexpr std::size_t numbers = sizeof(Sums) / sizeof(double);
    //! The same of place(): what links have to know of the whole body.
    struct Change
    {
        double weight = 0;  //!< of the links to one that several processes have, see weight_of()
        double excess = 0;  //!< of fluid that came to lie in it, or that it left
        std::array<double, D> given_back{};
    };
    static constexpr std::ptrdiff_t nothing = -1;
    static constexpr std::size_t changes = sizeof(Change) / sizeof(double);

    template <class Stored>
    static Stored& value(Rows<D, Stored> const& rows, std::size_t q, Extent const& place)
    {
        return rows.at(0, q, place[1], place[2])[place[0]];
    }
    template <class Stored>
    CellPopulations populations_of(Rows<D, Stored> const& rows, Extent const& at) const;
    void begin(std::size_t bodies, std::array<double, 3> const& half_force);
    void follow(std::span<std::uint64_t const> id);
    template <class Stored>
    Change cover(Rows<D, Stored> const& rows, Body<D> const& body, typename Cells::Changed const& change);
    template <class Stored>
    Change uncover(Rows<D, Stored> const& rows, Body<D> const& body, Cell const& cell) const;

    //! Cells whose populations one other process gets from here, and those that come from there.
    struct Border
    {
        std::vector<Extent> out, in;
    };
    std::map<int, Border> beside_left() const;
    void fetch_neighbours(Populations<D> const& populations);
    bool has_all_of(Body<D> const& body) const noexcept;
    void share_changes();
    void share_sums();

    double hydrostatic(std::array<double, D> const& arm) const;
    //! To the cell at +c_q; whether it is fluid.
    bool step_to_fluid(Extent& at, std::size_t q) const noexcept
    {
        return cells_.step(at, q) && cells_.owner(at) == Cells::nobody;
    }
    template <class Each>
    void each_link(std::size_t i, Body<D> const& body, Each&& each) const;
    std::uint32_t not_from(std::int32_t body, std::int32_t const* of_cell) const noexcept;
    double weight_of(std::size_t i, Body<D> const& body) const;
    template <class Stored>
    Link<Stored> find_link(Rows<D, Stored> const& rows, Body<D> const& body, Cell const& cell, std::size_t q,
                           Source const& source) const;
    template <class Stored>
    void reflect_link(Link<Stored> const& link, Body<D> const& body, double excess_given, Sums& sums) const;
    void press(Body<D> const& body, Cell const& cell, std::size_t q, Sums& sums) const;
    void add_cells(std::size_t i, std::ptrdiff_t lowest, std::span<Sums> layers) const;
    template <class Stored>
    void reflect_body(Rows<D, Stored> const& rows, std::size_t i, Body<D> const& body);
    template <class Stored>
    void fill(Rows<D, Stored> const& rows, Body<D> const& body, Run const& run) const;

    Domain<D> const& domain_;
    Cells cells_;
    std::vector<double> missing_;
    std::vector<double> weight_;                        //!< as Change's
    std::vector<Taken> taken_;                          //!< in this process, by body
    std::vector<SumPart<changes>> changes_;             //!< of the bodies, and after them of those of the step before
    std::vector<std::vector<SumPart<numbers>>> parts_;  //!< of each body
    std::vector<Body<D>> old_bodies_;
    std::vector<std::uint64_t> id_;
    std::vector<std::ptrdiff_t> was_;  //!< which body of the step before each is; -1: none
    std::vector<Impulse> impulse_, pressed_;
    std::vector<Sums> sums_;  //!< of each body
    std::array<double, 3> half_force_{};
    std::array<double, D> given_back_{};  //!< to the fluid, with cells that bodies left
    //! Cells of other processes beside some that bodies have left here.
    std::unordered_map<std::size_t, CellPopulations> foreign_;
};

//! Of a cell of this process, or of another's that has been fetched.
template <int D>
template <class Stored>
typename Links<D>::CellPopulations Links<D>::populations_of(Rows<D, Stored> const& rows, Extent const& at) const
{
    if (!cells_.is_here(at)) return foreign_.at(cells_.index(at));
    CellPopulations populations;
    Extent const place = cells_.place_of(at);
    for (std::size_t q = 0; q < populations.size(); ++q) populations[q] = value(rows, q, place);
    return populations;
}

}  // namespace lbm
