#pragma once

#include <cstdint>

#include "participants/lbm/cell_row.hpp"

//! Cells with solids at rest: what their collision needs follows from the solids alone and is found once.
namespace lbm {

//! Cells [begin, end) of a row, those with solids or those without.
struct StillRun
{
    std::ptrdiff_t begin, end;
    bool touched;
    std::size_t at;  //!< where its numbers are
    bool operator==(StillRun const&) const = default;
};

//! The runs of a row.
struct StillRow
{
    std::uint32_t at = 0, count = 0;  //!< where they are, and how many
    std::int32_t touched = 0;         //!< cells of those with solids
    bool in_block = false;            //!< collides in a StillBlock, if it has solids that rest and no others
};

//! Rows that lie in line. Slots are counted from the first one's cell x = 0 on.
template <class Stored>
struct StillBlock
{
    std::ptrdiff_t cells = 0, count = 0, stride = 0;  //!< of a row; rows; slots from one to the next
    StillRow const* rows = nullptr;
    //! All touched; those of a row a register or more apart. The last one may go on as the first one of the next row.
    StillRun const* runs = nullptr;
    Stored const* numbers = nullptr;
    std::array<Stored*, 3> force{};  //!< out: 2 B/eps j; a solid's force is eps times that. Room for whole registers
    OnTheWay* on_the_way = nullptr;
};
using AnyStillBlock = AnyRow<StillBlock>;

//! What is known of a cell: it keeps 1 - B of its momentum, by `pull` times that its odd part is pulled (change() in
//! collide_space.hpp); 2 B/eps; its rates, 0 of the stress where the fluid's eddies act.
enum class StillNumber
{
    left,
    pull,
    push,
    shear,
    energy,
    square,
    flux
};
inline constexpr std::ptrdiff_t still_numbers = 7;

//! The numbers of a run, one array after the other. Any register that has cells of the run finds those of all its
//! cells.
template <class Stored>
class StillNumbers
{
 public:
    static constexpr auto lanes = static_cast<std::ptrdiff_t>(Lanes<Stored>::count);

    static constexpr std::ptrdiff_t length(StillRun const& run) noexcept { return run.end - run.begin + 2 * lanes; }

    StillNumbers() = default;
    //! Of a register that begins at the run's slot x.
    StillNumbers(Stored const* numbers, StillRun const& run, std::ptrdiff_t x) noexcept
        : first_(numbers + (static_cast<std::ptrdiff_t>(run.at) + x - run.begin + lanes)), length_(length(run))
    {}
    //! Of one so many slots further on.
    [[gnu::always_inline]] StillNumbers from(std::ptrdiff_t x) const noexcept
    {
        StillNumbers numbers = *this;
        numbers.first_ += x;
        return numbers;
    }
    [[gnu::always_inline]] Lanes<Stored> operator[](StillNumber number) const noexcept
    {
        return load<Lanes<Stored>>(first_ + static_cast<std::ptrdiff_t>(number) * length_);
    }

 private:
    Stored const* first_ = nullptr;
    std::ptrdiff_t length_ = 0;
};

//! A register's numbers, and what its solids get.
template <class V>
struct StillCell
{
    V left, pull, push;
    Rates<V> rates;
    std::array<V, 3> force;

    template <class Stored>
    [[gnu::always_inline]] explicit StillCell(StillNumbers<Stored> const& of) noexcept
        : left(of[StillNumber::left]),
          pull(of[StillNumber::pull]),
          push(of[StillNumber::push]),
          rates{of[StillNumber::shear], of[StillNumber::energy], of[StillNumber::square], of[StillNumber::flux]}
    {}
};

}  // namespace lbm
