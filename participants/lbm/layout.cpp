#include "participants/lbm/layout.hpp"

#include <algorithm>
#include <numeric>

namespace lbm {

Layout::Layout(Extent cells, std::vector<Box> boxes) : cells_(cells), boxes_(std::move(boxes))
{
    auto const narrow = [](std::ptrdiff_t n) { return static_cast<std::int32_t>(n); };
    for (std::size_t b = 0; b < boxes_.size(); ++b) {
        auto const& [first, size] = boxes_[b];
        stored_ += boxes_[b].cells();
        first_rows_.push_back(rows());
        widest_ = std::max(widest_, size[0]);
        for (std::ptrdiff_t z = 0; z < size[2]; ++z)
            for (std::ptrdiff_t y = 0; y < size[1]; ++y)
                rows_.push_back({static_cast<std::int32_t>(b), narrow(first[0]), narrow(size[0]), narrow(first[1] + y),
                                 narrow(first[2] + z)});
    }
    auto const place = [&](std::uint32_t r) {
        return static_cast<std::size_t>(rows_[r].z) * static_cast<std::size_t>(cells_[1]) +
               static_cast<std::size_t>(rows_[r].y);
    };
    by_place_.resize(rows_.size());
    std::iota(by_place_.begin(), by_place_.end(), 0U);
    std::sort(by_place_.begin(), by_place_.end(), [&](std::uint32_t a, std::uint32_t b) {
        return place(a) != place(b) ? place(a) < place(b) : rows_[a].first < rows_[b].first;
    });
    place_start_.assign(static_cast<std::size_t>(cells_[1] * cells_[2]) + 1, 0);
    for (std::uint32_t const r : by_place_) ++place_start_[place(r) + 1];
    for (std::size_t k = 1; k < place_start_.size(); ++k) {
        most_across_ = std::max<std::size_t>(most_across_, place_start_[k]);
        place_start_[k] += place_start_[k - 1];
    }
}

std::int32_t Layout::box_of(Extent const& cell) const noexcept
{
    for (std::uint32_t const r : across(cell[1], cell[2]))
        if (Row const& row = rows_[r]; cell[0] >= row.first && cell[0] < row.first + row.cells) return row.box;
    return -1;
}

}  // namespace lbm
