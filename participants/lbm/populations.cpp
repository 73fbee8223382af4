#include "participants/lbm/populations.hpp"

#include <sys/mman.h>

#include <algorithm>
#include <cstring>
#include <string>

#include "coupler/base/error.hpp"
#include "participants/lbm/lanes.hpp"

namespace lbm {
namespace {

constexpr std::size_t huge_page = 2UL << 20;  //!< [B]
//! Steps between two moves back of the directions that leave along x: a half per cent of the traffic.
constexpr std::ptrdiff_t slack = 128;

constexpr std::ptrdiff_t round_up(std::ptrdiff_t n, std::ptrdiff_t to)
{
    return (n + to - 1) / to * to;
}

//! An odd number of cache lines: planes and arrays then never fall into one set of the cache.
constexpr std::ptrdiff_t pad(std::ptrdiff_t n, std::ptrdiff_t line)
{
    return (round_up(n, line) / line | 1) * line;
}

//! Slots from a row of so many cells to the next, with room for a ghost cell. Long rows lie in whole cache lines, but
//! not so many that those above one another fall into one set; short ones do not, since the machine would fetch what
//! lies between them as well.
constexpr std::ptrdiff_t row_stride(std::ptrdiff_t cells, std::ptrdiff_t line)
{
    constexpr std::ptrdiff_t longer = 64, in_a_set = 8;  // lines
    std::ptrdiff_t const slots = cells + 1 < longer * line ? cells + 1 : round_up(cells + 1, line);
    return slots % (in_a_set * line) == 0 && slots > in_a_set * line ? slots + line : slots;
}

}  // namespace

//! Lays a box's arrays out from `begin` on; returns where they end.
template <int D>
std::ptrdiff_t Populations<D>::add_box(Extent const& size, std::ptrdiff_t begin)
{
    Arrays a;
    a.stride = row_stride(size[0], line_);
    for (std::size_t q = 0; q < directions; ++q) {
        auto const& c = Lattice<D>::c[q];
        a.rows[q] = size[1] + std::abs(c[1]);
        a.planes[q] = size[2] + std::abs(c[2]);
        a.plane[q] = D == 2 ? a.rows[q] * a.stride : pad(a.rows[q] * a.stride, line_);
        a.begin[q] = begin + (c[0] > 0 ? slack : c[0] < 0 ? 1 : 0);  // the origin moves down as they move up
        begin += pad(a.planes[q] * a.plane[q] + (c[0] == 0 ? 0 : slack + 1), line_);
    }
    arrays_.push_back(a);
    return begin;
}

template <int D>
Populations<D>::Populations(Layout const& layout, Precision precision, sluice::Team& team)
    : layout_(&layout), precision_(precision), line_(cache_line / static_cast<std::ptrdiff_t>(bytes_of(precision)))
{
    std::ptrdiff_t length = 0;
    for (Box const& box : layout.boxes()) length = add_box(box.size, length);
    for (auto& ends : ends_) ends.resize(static_cast<std::size_t>(rows() * along_x<D>) * bytes_of(precision));
    bytes_ = (static_cast<std::size_t>(length) * bytes_of(precision) + huge_page - 1) / huge_page * huge_page;
    memory_.reset(static_cast<std::byte*>(std::aligned_alloc(huge_page, bytes_)));
    sluice::require(memory_ != nullptr, [&] {
        return sluice::Error("fluid: " + std::to_string(bytes_ >> 20) +
                                 " MiB for the lattice are not to be had. Take a larger cell or a smaller domain.",
                             sluice::Exit::io);
    });
    madvise(memory_.get(), bytes_, MADV_HUGEPAGE);
    auto const pages = static_cast<std::ptrdiff_t>(bytes_ / huge_page);
    team.share(pages, 1, [&](std::ptrdiff_t from, std::ptrdiff_t to) {
        std::memset(memory_.get() + static_cast<std::size_t>(from) * huge_page, 0,
                    static_cast<std::size_t>(to - from) * huge_page);
    });
}

template <int D>
void Populations<D>::move_back(Arrays const& a, std::size_t q)
{
    auto const size = static_cast<std::ptrdiff_t>(bytes_of(precision_));
    int const along = Lattice<D>::c[q][0];
    std::byte* const first = memory_.get() + (a.begin[q] - (along < 0 ? 1 : 0)) * size;  // with the ghost cell at -1
    std::memmove(first, first - along * drift_ * size, static_cast<std::size_t>(a.planes[q] * a.plane[q] * size));
}

template <int D>
void Populations<D>::stream(sluice::Team& team)
{
    if (drift_ == slack) {
        auto const arrays = static_cast<std::ptrdiff_t>(arrays_.size() * directions);
        team.share(arrays, 1, [&](std::ptrdiff_t begin, std::ptrdiff_t end) {
            for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i)
                if (Lattice<D>::c[i % directions][0] != 0) move_back(arrays_[i / directions], i % directions);
        });
        drift_ = 0;
    }
    for (Arrays& a : arrays_)
        for (std::size_t q = 0; q < directions; ++q) {
            a.y0[q] = in_ring(a.y0[q] - Lattice<D>::c[q][1], a.rows[q]);
            a.z0[q] = in_ring(a.z0[q] - Lattice<D>::c[q][2], a.planes[q]);
        }
    ++drift_;
    std::swap(ends_[0], ends_[1]);
}

template class Populations<2>;
template class Populations<3>;

}  // namespace lbm
