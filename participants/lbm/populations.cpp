#include "participants/lbm/populations.hpp"

#include <sys/mman.h>

#include <algorithm>
#include <cstring>
#include <vector>

#include "coupler/base/error.hpp"

namespace lbm {
namespace {

constexpr std::ptrdiff_t line = 8;            //!< doubles in a cache line
constexpr std::size_t huge_page = 2UL << 20;  //!< [B]
constexpr std::ptrdiff_t slack_rows = 100;    //!< steps between two moves back: 1 % of the traffic (lbm_bench)

constexpr std::ptrdiff_t round_up(std::ptrdiff_t n, std::ptrdiff_t to)
{
    return (n + to - 1) / to * to;
}

//! An odd number of cache lines: rows and columns of neighbours then never fall into one set of the cache.
constexpr std::ptrdiff_t pad(std::ptrdiff_t n)
{
    return (round_up(n, line) / line | 1) * line;
}

}  // namespace

Populations::Populations(std::ptrdiff_t nx, std::ptrdiff_t ny, sluice::Team& team)
    : nx_(nx), ny_(ny), stride_(pad(nx + line + 1)), slack_(slack_rows * stride_)
{
    std::ptrdiff_t const body = (ny + 2) * stride_ + 2 * line;
    std::ptrdiff_t const length = pad(body + slack_);
    bytes_ = (directions * static_cast<std::size_t>(length) * sizeof(double) + huge_page - 1) / huge_page * huge_page;
    memory_.reset(static_cast<double*>(std::aligned_alloc(huge_page, bytes_)));
    sluice::require(memory_ != nullptr, [&] {
        return sluice::Error("fluid: " + std::to_string(bytes_ >> 20) +
                                 " MiB for the lattice are not to be had. Take a larger cell or a smaller domain.",
                             sluice::Exit::io);
    });
    madvise(memory_.get(), bytes_, MADV_HUGEPAGE);
    for (std::size_t q = 0; q < directions; ++q) {
        std::ptrdiff_t const low = shift(q) > 0 ? slack_ : 0;  // the origin moves down when the population moves up
        start_[q] = memory_.get() + static_cast<std::ptrdiff_t>(q) * length + low + stride_ + line;
    }
    origin_ = start_;
    auto const pages = static_cast<std::ptrdiff_t>(bytes_ / huge_page);
    team.share(pages, 1, [&](std::ptrdiff_t begin, std::ptrdiff_t end) {
        char* const first = reinterpret_cast<char*>(memory_.get()) + static_cast<std::size_t>(begin) * huge_page;
        std::memset(first, 0, static_cast<std::size_t>(end - begin) * huge_page);
    });
}

Slots Populations::row(std::ptrdiff_t y) noexcept
{
    Slots slots;
    for (std::size_t q = 0; q < directions; ++q) slots[q] = row(q, y);
    return slots;
}

void Populations::stream(sluice::Team& team)
{
    std::vector<std::size_t> used_up;
    for (std::size_t q = 0; q < directions; ++q) {
        if (std::abs(origin_[q] - start_[q]) + std::abs(shift(q)) > slack_) used_up.push_back(q);
    }
    if (!used_up.empty()) {
        std::ptrdiff_t const before = stride_ + 1;  // the ghost corner (-1, -1)
        auto const size = static_cast<std::size_t>((ny_ + 2) * stride_ + 2) * sizeof(double);
        team.share(static_cast<std::ptrdiff_t>(used_up.size()), 1, [&](std::ptrdiff_t begin, std::ptrdiff_t end) {
            for (std::ptrdiff_t i = begin; i < end; ++i) {
                std::size_t const q = used_up[static_cast<std::size_t>(i)];
                std::memmove(start_[q] - before, origin_[q] - before, size);
                origin_[q] = start_[q];
            }
        });
    }
    for (std::size_t q = 0; q < directions; ++q) origin_[q] -= shift(q);
}

}  // namespace lbm
