#include "participants/lbm/populations.hpp"

#include <sys/mman.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <vector>

#include "coupler/base/error.hpp"

namespace lbm {
namespace {

constexpr std::size_t line_bytes = 64;        //!< of the cache
constexpr std::size_t huge_page = 2UL << 20;  //!< [B]
//! Steps between two moves back: 1 % of the traffic (lbm_bench); in space, of the directions that leave their plane: 3
//! %, for an eighth more of a lattice of 128 planes.
constexpr std::ptrdiff_t slack_rows = 100, slack_planes = 16;

constexpr std::ptrdiff_t round_up(std::ptrdiff_t n, std::ptrdiff_t to)
{
    return (n + to - 1) / to * to;
}

//! An odd number of cache lines: planes and arrays then never fall into one set of the cache.
constexpr std::ptrdiff_t pad(std::ptrdiff_t n, std::ptrdiff_t line)
{
    return (round_up(n, line) / line | 1) * line;
}

//! A row's cells with a ghost at each end, in whole cache lines, but not so many that rows above one another fall into
//! one set.
constexpr std::ptrdiff_t row_stride(std::ptrdiff_t cells, std::ptrdiff_t line)
{
    std::ptrdiff_t const lines = round_up(cells + 2, line) / line;
    return (lines % 8 == 0 ? lines + 1 : lines) * line;
}

}  // namespace

template <int D>
std::ptrdiff_t Populations<D>::slack(std::size_t q) const noexcept
{
    return std::abs(Lattice<D>::c[q][2]) > 0 ? slack_planes * plane_ : slack_rows * stride_;
}

template <int D>
Populations<D>::Populations(Extent cells, Precision precision, sluice::Team& team)
    : cells_(cells),
      precision_(precision),
      line_(static_cast<std::ptrdiff_t>(line_bytes / bytes_of(precision))),
      stride_(row_stride(cells[0], line_)),
      plane_(D == 2 ? 0 : pad((cells[1] + 2) * stride_, line_)),
      body_((D == 2 ? (cells[1] + 2) * stride_ : (cells[2] + 2) * plane_) + 2 * line_)
{
    std::array<std::ptrdiff_t, Lattice<D>::directions> begin;
    std::ptrdiff_t length = 0;
    for (std::size_t q = 0; q < begin.size(); ++q) {
        begin[q] = length;
        length += pad(body_ + slack(q), line_);
    }
    bytes_ = (static_cast<std::size_t>(length) * bytes_of(precision) + huge_page - 1) / huge_page * huge_page;
    memory_.reset(static_cast<std::byte*>(std::aligned_alloc(huge_page, bytes_)));
    sluice::require(memory_ != nullptr, [&] {
        return sluice::Error("fluid: " + std::to_string(bytes_ >> 20) +
                                 " MiB for the lattice are not to be had. Take a larger cell or a smaller domain.",
                             sluice::Exit::io);
    });
    madvise(memory_.get(), bytes_, MADV_HUGEPAGE);
    for (std::size_t q = 0; q < begin.size(); ++q) {
        std::ptrdiff_t const low = shift(q) > 0 ? slack(q) : 0;  // the origin moves down when the population moves up
        start_[q] = begin[q] + low + plane_ + stride_ + line_;
    }
    origin_ = start_;
    auto const pages = static_cast<std::ptrdiff_t>(bytes_ / huge_page);
    team.share(pages, 1, [&](std::ptrdiff_t from, std::ptrdiff_t to) {
        std::memset(memory_.get() + static_cast<std::size_t>(from) * huge_page, 0,
                    static_cast<std::size_t>(to - from) * huge_page);
    });
}

template <int D>
void Populations<D>::stream(sluice::Team& team)
{
    std::vector<std::size_t> used_up;
    for (std::size_t q = 0; q < origin_.size(); ++q) {
        if (std::abs(origin_[q] - start_[q]) + std::abs(shift(q)) > slack(q)) used_up.push_back(q);
    }
    if (!used_up.empty()) {
        std::ptrdiff_t const before = plane_ + stride_ + 1;  // the ghost corner (-1, -1, -1)
        auto const size = static_cast<std::size_t>(body_ - 2 * line_ + 2) * bytes_of(precision_);
        team.share(static_cast<std::ptrdiff_t>(used_up.size()), 1, [&](std::ptrdiff_t begin, std::ptrdiff_t end) {
            for (std::ptrdiff_t i = begin; i < end; ++i) {
                std::size_t const q = used_up[static_cast<std::size_t>(i)];
                std::memmove(slot(start_[q] - before), slot(origin_[q] - before), size);
                origin_[q] = start_[q];
            }
        });
    }
    for (std::size_t q = 0; q < origin_.size(); ++q) origin_[q] -= shift(q);
}

template class Populations<2>;
template class Populations<3>;

}  // namespace lbm
