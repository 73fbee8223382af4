#include "participants/lbm/row_ends.hpp"

#include "participants/lbm/lanes.hpp"

namespace lbm {
namespace {

//! Cells that are asked for at a time.
template <class Stored>
constexpr std::ptrdiff_t at_once = 2 * cache_line / std::ptrdiff_t{sizeof(Stored)};
//! How far before a row's end a kernel is when what enters there, and the next row, is written: lines that it asks for
//! ahead have come, and it does not read them before they are written.
template <class Stored>
constexpr std::ptrdiff_t ahead = 4 * cache_line / std::ptrdiff_t{sizeof(Stored)};
//! How far beyond a cell it is when it has written it: it may read one register before it writes the last one.
template <class Stored>
constexpr std::ptrdiff_t behind = 2 * std::ptrdiff_t{register_bytes} / std::ptrdiff_t{sizeof(Stored)};

}  // namespace

template <int D, class Stored>
RowEnds<D, Stored>::RowEnds(Rows<D, Stored> const& rows, Walls const& walls, std::ptrdiff_t begin, std::ptrdiff_t end,
                            bool enters)
    : OnTheWay{rows.nx(begin) - ahead<Stored>,
               [](OnTheWay& self, std::ptrdiff_t at) { static_cast<RowEnds&>(self).pass(at); }},
      rows_(rows),
      walls_(walls),
      begin_(begin),
      count_(end - begin),
      stride_(rows.stride(begin)),
      cells_(rows.nx(begin)),
      enters_(enters),
      row_end_(due),
      asked_(cells_),
      from_low_{0, half},
      from_high_{cells_ - 1, 0}
{
    auto const slots = rows.row(begin);
    for (std::size_t q = 0; q < slots.size(); ++q) {
        int const along = Lattice<D>::c[q][0];
        if (along == 0) continue;
        Departures& departures = along > 0 ? from_high_ : from_low_;
        departures.from[static_cast<std::size_t>(place_along_x<D>[q] - departures.place)] = slots[q] + departures.cell;
    }
    if (enters_) enter(0);
    if (asked_ < cells_) due = 0;
}

//! When the kernel is about to read the cells from `at` on.
template <int D, class Stored>
void RowEnds<D, Stored>::pass(std::ptrdiff_t at)
{
    if (row_end_ <= at) {
        for (; here_ < count_ && row_end_ <= at; ++here_, row_end_ += stride_) {
            if (!enters_) continue;
            write(into_high_, here_);
            if (here_ + 1 < count_) enter(here_ + 1);
        }
        note(from_high_, at);
        note(from_low_, at);
    }
    due = here_ == count_ ? std::numeric_limits<std::ptrdiff_t>::max() : row_end_;
    if (asked_ >= cells_) return;
    ask(at_once<Stored>);
    due = std::min(due, at + at_once<Stored>);
}

//! What enters a row from outside, but at its high end.
template <int D, class Stored>
void RowEnds<D, Stored>::enter(std::ptrdiff_t row)
{
    std::ptrdiff_t const r = begin_ + row;
    if (links_ != &walls_.entrances.of_row(r)) list(row);
    write(into_low_, row);
    ask(cells_);
    auto known = coming_.begin();
    for (Entrance const* const link : others_) {
        bool const here = known != coming_.end() && known->link == link;
        enter_link(rows_, r, *link, walls_, here ? (known++)->from : source(rows_, r, *link));
    }
    coming_.clear();
    if (r + 1 < rows_.rows()) look_ahead(r + 1);
}

//! Where what enters the row after this one along all of it comes from.
template <int D, class Stored>
void RowEnds<D, Stored>::look_ahead(std::ptrdiff_t r)
{
    auto const& links = walls_.entrances.of_row(r);
    if (&links == links_ && others_.empty()) return;
    for (Entrance const& link : links)
        if (link.cells > 1) coming_.push_back({&link, source(rows_, r, link)});
    if (!coming_.empty()) asked_ = 0;
}

//! Asks for what is coming to so many more cells: it lies far from the rest. At the kernel's pace, whose own lines
//! would have to wait else.
template <int D, class Stored>
void RowEnds<D, Stored>::ask(std::ptrdiff_t cells)
{
    if (asked_ >= cells_) return;
    for (auto const& [link, from] : coming_)
        if (asked_ < link->cells) prefetch(from + asked_, std::min(cells, link->cells - asked_));
    asked_ += cells;
}

//! Lists what enters this row at its ends, and those after it that are alike.
template <int D, class Stored>
void RowEnds<D, Stored>::list(std::ptrdiff_t row)
{
    std::ptrdiff_t const r = begin_ + row;
    links_ = &walls_.entrances.of_row(r);
    listed_ = row;
    others_.clear();
    into_low_.count = into_high_.count = 0;
    for (Entrance const& link : *links_) {
        Stored const* const from = comes_from_end(rows_, r, link);
        if (from == nullptr) {
            others_.push_back(&link);
            continue;
        }
        Arrivals& arrivals = Lattice<D>::c[link.into][0] > 0 ? into_low_ : into_high_;
        arrivals.all[arrivals.count++] = {rows_.row(link.into, r) + link.x, from, link.push};
    }
}

template <int D, class Stored>
void RowEnds<D, Stored>::write(Arrivals const& arrivals, std::ptrdiff_t row) const noexcept
{
    std::ptrdiff_t const k = row - listed_;
    for (std::size_t i = 0; i < arrivals.count; ++i) {
        auto const& [into, from, push] = arrivals.all[i];
        Stored const left = from[k * along_x<D>];
        into[k * stride_] = push == 0 ? left : static_cast<Stored>(left + push);
    }
}

//! Of rows that have been passed when the kernel is about to read the cells from `at` on.
template <int D, class Stored>
void RowEnds<D, Stored>::note(Departures& departures, std::ptrdiff_t at) const noexcept
{
    auto& [cell, place, from, noted] = departures;
    for (; noted < count_ && noted * stride_ + cell + behind<Stored> < at; ++noted) {
        Stored* const to = rows_.leaving(begin_ + noted) + place;
        for (std::size_t i = 0; i < half; ++i) to[i] = from[i][noted * stride_];
    }
}

template <int D, class Stored>
void RowEnds<D, Stored>::finish() noexcept
{
    constexpr auto end = std::numeric_limits<std::ptrdiff_t>::max();
    note(from_high_, end);
    note(from_low_, end);
}

template class RowEnds<2, double>;
template class RowEnds<2, float>;
template class RowEnds<3, double>;
template class RowEnds<3, float>;

}  // namespace lbm
