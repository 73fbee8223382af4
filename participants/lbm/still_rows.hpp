#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <tuple>
#include <vector>

#include "participants/lbm/shared_runs.hpp"
#include "participants/lbm/still_numbers.hpp"

namespace lbm {

//! What the collision needs of rows in which all solids rest, found once.
struct StillRows
{
    template <class Stored>
    struct Numbers
    {
        SharedRuns<Stored> of_runs{};  //!< with solids: StillNumbers; or fractions, weights, open shares and eases
        std::vector<Stored> rest{};    //!< momentum of solids in a row: none
    };
    //! What is found of a row by itself.
    template <class Stored>
    struct Known
    {
        bool in_block;
        StillRowNumbers<Stored> of_cells{};  //!< if in_block
        std::vector<StillRun> alone{};       //!< else
    };
    //! Unless there are no solids at rest. What is not in_block collides run by run, those with solids as a SolidRow.
    std::vector<StillRow> rows{};
    SharedRuns<StillRun> runs{};
    std::tuple<Numbers<double>, Numbers<float>> numbers{};  //!< those of the type that is stored

    template <class Stored>
    Numbers<Stored>& typed() noexcept
    {
        return std::get<Numbers<Stored>>(numbers);
    }
    template <class Stored>
    Numbers<Stored> const& typed() const noexcept
    {
        return std::get<Numbers<Stored>>(numbers);
    }
    StillRow row(std::ptrdiff_t r) const noexcept
    {
        return rows.empty() ? StillRow{} : rows[static_cast<std::size_t>(r)];
    }
    std::span<StillRun const> runs_of(StillRow const& row) const noexcept { return {runs.data(row.at), row.count}; }
    //! A row of so many cells; its last run may go on in the next one.
    void add_row(std::ptrdiff_t cells, std::span<StillRun const> of_row, bool in_block)
    {
        StillRow row{.in_block = in_block};
        if (!of_row.empty()) row.at = static_cast<std::uint32_t>(runs.add(of_row));
        row.count = static_cast<std::uint32_t>(of_row.size());
        for (StillRun const& run : of_row)
            if (run.touched) row.touched += static_cast<std::int32_t>(std::min(run.end, cells) - run.begin);
        rows.push_back(row);
    }
    //! Lets a row's arrays be those of a run.
    template <class Stored>
    void point(StillRun const& run, SolidRow<Stored>& row) const noexcept
    {
        std::ptrdiff_t const cells = run.end - run.begin;
        row.fraction = typed<Stored>().of_runs.data(run.at) - run.begin;
        row.weight = row.fraction + cells;
        row.open = row.weight + cells;
        row.ease = row.open + cells;
    }
    std::size_t bytes() const noexcept
    {
        return typed<double>().of_runs.bytes() + typed<float>().of_runs.bytes() + runs.bytes() +
               sizeof(StillRow) * rows.size();
    }
};

}  // namespace lbm
