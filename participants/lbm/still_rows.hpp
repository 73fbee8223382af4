#pragma once

#include <cstdint>
#include <span>
#include <tuple>
#include <vector>

#include "participants/lbm/cell_row.hpp"
#include "participants/lbm/shared_runs.hpp"

namespace lbm {

//! What the collision needs of rows in which all solids rest (SolidRow), found once.
struct StillRows
{
    //! Cells [begin, end) of a row, with or without solids.
    struct Run
    {
        std::ptrdiff_t begin, end;
        bool touched;
        std::size_t at;  //!< in Numbers::of_runs
    };
    //! Of runs with solids: fractions, weights, open shares and eases.
    template <class Stored>
    struct Numbers
    {
        SharedRuns<Stored> of_runs{};
        std::vector<Stored> rest{};  //!< momentum of solids in a row: none
    };
    std::vector<Run> runs{};
    std::vector<std::uint32_t> start{};                     //!< for each row, in runs; and its end
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
    std::span<Run const> of_row(std::ptrdiff_t r) const noexcept
    {
        auto const at = static_cast<std::size_t>(r);
        return {runs.data() + start[at], runs.data() + start[at + 1]};
    }
    template <class Stored>
    void add_run(std::ptrdiff_t begin, std::ptrdiff_t end, bool touched, SolidRow<Stored> const& row)
    {
        std::size_t at = 0;
        if (touched) {
            std::vector<Stored> run;
            for (Stored const* from : {row.fraction, row.weight, row.open, row.ease})
                run.insert(run.end(), from + begin, from + end);
            at = typed<Stored>().of_runs.add(run);
        }
        runs.push_back({begin, end, touched, at});
    }
    //! Lets a row's arrays be those of a run.
    template <class Stored>
    void point(Run const& run, SolidRow<Stored>& row) const noexcept
    {
        std::ptrdiff_t const cells = run.end - run.begin;
        row.fraction = typed<Stored>().of_runs.data(run.at) - run.begin;
        row.weight = row.fraction + cells;
        row.open = row.weight + cells;
        row.ease = row.open + cells;
    }
    std::size_t bytes() const noexcept
    {
        return typed<double>().of_runs.bytes() + typed<float>().of_runs.bytes() + sizeof(Run) * runs.size();
    }
};

}  // namespace lbm
