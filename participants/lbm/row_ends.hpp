#pragma once

#include <array>

#include "participants/lbm/cell_row.hpp"
#include "participants/lbm/populations.hpp"
#include "participants/lbm/walls.hpp"

namespace lbm {

//! What is to be done about the ends of rows that collide in one call of a kernel: what enters a row from outside is
//! written shortly before the kernel comes there, what leaves it at its ends is noted shortly after it has passed. The
//! lines are in the cache then: they have been asked for ahead, or just been written.
template <int D, class Stored>
class RowEnds : public OnTheWay
{
 public:
    //! Of rows [begin, end) that lie in line. `enters`: unless what comes from outside has been written. Keeps the
    //! addresses.
    RowEnds(Rows<D, Stored> const& rows, Walls const& walls, std::ptrdiff_t begin, std::ptrdiff_t end, bool enters);
    RowEnds(RowEnds const&) = delete;
    RowEnds& operator=(RowEnds const&) = delete;

    void finish() noexcept;  //!< when all has collided

 private:
    static constexpr std::size_t half = static_cast<std::size_t>(along_x<D>) / 2;
    //! What enters rows that are alike at one end; of the first of them.
    struct Arrivals
    {
        struct One
        {
            Stored* into;
            Stored const* from;
            double push;
        };
        std::array<One, half> all;
        std::size_t count = 0;
    };
    //! What enters a row along all of it.
    struct Coming
    {
        Entrance const* link;
        Stored const* from;
    };
    //! What leaves rows at one end.
    struct Departures
    {
        std::ptrdiff_t cell, place;              //!< x, and where the first one is noted
        std::array<Stored const*, half> from{};  //!< of the first row
        std::ptrdiff_t noted = 0;                //!< rows
    };

    void pass(std::ptrdiff_t at);
    void enter(std::ptrdiff_t row);
    void look_ahead(std::ptrdiff_t r);
    void ask(std::ptrdiff_t cells);
    void list(std::ptrdiff_t row);
    void write(Arrivals const& arrivals, std::ptrdiff_t row) const noexcept;
    void note(Departures& departures, std::ptrdiff_t at) const noexcept;

    Rows<D, Stored> const& rows_;
    Walls const& walls_;
    std::ptrdiff_t begin_, count_, stride_, cells_;
    bool enters_;
    std::ptrdiff_t row_end_;   //!< shortly before it, what enters there and the next row is written
    std::ptrdiff_t here_ = 0;  //!< the row that the kernel is in; rows count from the first one
    std::vector<Entrance> const* links_ = nullptr;  //!< of the rows that are listed
    std::ptrdiff_t listed_ = 0;                     //!< the first one
    std::vector<Entrance const*> others_{};         //!< of these, what enters elsewhere
    Arrivals into_low_{}, into_high_{};
    std::vector<Coming> coming_{};  //!< to the next row
    std::ptrdiff_t asked_;          //!< cells of that row
    Departures from_low_, from_high_;
};

}  // namespace lbm
