#include "coupler/mapping/lattice_mapping.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <type_traits>

#include "coupler/base/error.hpp"
#include "coupler/mapping/lanes.hpp"
#include "coupler/mapping/lattice_weights.hpp"

namespace sluice {

namespace {

template <int N>
using Constant = std::integral_constant<int, N>;
template <LatticeKernel K>
using KernelConstant = std::integral_constant<LatticeKernel, K>;

//! Calls work(dimension, kernel) with constants: one dispatch a call, none in the loops.
template <class Work>
void dispatch(int dimension, LatticeKernel kernel, Work&& work)
{
    auto const with_dimension = [&](auto k) { dimension == 2 ? work(Constant<2>{}, k) : work(Constant<3>{}, k); };
    switch (kernel) {
        case LatticeKernel::hat:
            return with_dimension(KernelConstant<LatticeKernel::hat>{});
        case LatticeKernel::three_point:
            return with_dimension(KernelConstant<LatticeKernel::three_point>{});
        case LatticeKernel::four_point:
            return with_dimension(KernelConstant<LatticeKernel::four_point>{});
    }
}

//! Calls work(components a point): a constant for 1 to 3, 0 for any other.
template <class Work>
void with_width(int width, Work&& work)
{
    switch (width) {
        case 1:
            return work(Constant<1>{});
        case 2:
            return work(Constant<2>{});
        case 3:
            return work(Constant<3>{});
        default:
            return work(Constant<0>{});
    }
}

//! A point's block of S^D cells: calls visit(offset of a row of S cells, product of the weights across the row).
template <int D, int S, class Visit>
inline void visit_rows(double const* weight, std::int64_t row, std::int64_t layer, Visit&& visit)
{
    double const* const wy = weight + S;
    if constexpr (D == 2) {
        for (int j = 0; j < S; ++j) visit(j * row, wy[j]);
    } else {
        double const* const wz = weight + 2 * S;
        for (int k = 0; k < S; ++k)
            for (int j = 0; j < S; ++j) visit(j * row + k * layer, wz[k] * wy[j]);
    }
}

//! out = weighted sum over the block at `cells`. W components, or `width` where W is 0.
template <int D, int S, int W>
inline void gather_point(double const* weight, double const* cells, std::int64_t row, std::int64_t layer, int width,
                         double* out)
{
    if constexpr (W > 0) {
        Lanes<S * W> rows;  // their sum; a row's cells and components are one piece of memory
        visit_rows<D, S>(weight, row * W, layer * W,
                         [&](std::int64_t offset, double w) { rows.add(w, cells + offset); });
        double sum[S * W];
        rows.store(sum);
        for (int c = 0; c < W; ++c) {
            double total = 0;
            for (int i = 0; i < S; ++i) total += weight[i] * sum[i * W + c];
            out[c] = total;
        }
    } else {
        for (int c = 0; c < width; ++c) out[c] = 0;
        visit_rows<D, S>(weight, row * width, layer * width, [&](std::int64_t offset, double w) {
            for (int i = 0; i < S; ++i)
                for (int c = 0; c < width; ++c) out[c] += w * weight[i] * cells[offset + i * width + c];
        });
    }
}

//! The transpose: adds in, weighted, to the block at `cells`.
template <int D, int S, int W>
inline void spread_point(double const* weight, double* cells, std::int64_t row, std::int64_t layer, int width,
                         double const* in)
{
    if constexpr (W > 0) {
        double along[S * W];
        for (int i = 0; i < S; ++i)
            for (int c = 0; c < W; ++c) along[i * W + c] = weight[i] * in[c];
        Lanes<S * W> rows;
        rows.load(along);
        visit_rows<D, S>(weight, row * W, layer * W,
                         [&](std::int64_t offset, double w) { rows.add_to(w, cells + offset); });
    } else {
        visit_rows<D, S>(weight, row * width, layer * width, [&](std::int64_t offset, double w) {
            for (int i = 0; i < S; ++i)
                for (int c = 0; c < width; ++c) cells[offset + i * width + c] += w * weight[i] * in[c];
        });
    }
}

void need_size(char const* what, std::size_t seen, std::size_t points, int width)
{
    require(width > 0 && seen == points * static_cast<std::size_t>(width), [&] {
        return Error(std::string("lattice mapping: ") + std::to_string(seen) + " values at the " + what +
                         " (needed: " + std::to_string(points) + " of " + std::to_string(width) + ").",
                     Exit::internal);
    });
}

void check(Lattice const& lattice, LatticeKernel kernel)
{
    auto const refuse = [](std::string const& text) { return Error("lattice mapping: " + text); };
    require(lattice.dimension == 2 || lattice.dimension == 3,
            [&] { return refuse("dimension " + std::to_string(lattice.dimension) + " (needed: 2 or 3)."); });
    require(lattice.spacing > 0 && std::isfinite(lattice.spacing),
            [&] { return refuse("spacing = " + std::to_string(lattice.spacing) + " m (must be > 0 and finite)."); });
    double size = 1;
    for (std::size_t axis = 0; axis < static_cast<std::size_t>(lattice.dimension); ++axis) {
        require(std::isfinite(lattice.origin[axis]), [&] { return refuse("the origin is not finite."); });
        require(lattice.cells[axis] >= support(kernel), [&] {
            return refuse(std::to_string(lattice.cells[axis]) + " cells along axis " + std::to_string(axis) +
                          " (needed: " + std::to_string(support(kernel)) + " for this kernel).");
        });
        size *= static_cast<double>(lattice.cells[axis]);
    }
    require(size < 1e15, [&] { return refuse("more than 1e15 cells."); });
}

}  // namespace

std::size_t Lattice::size() const noexcept
{
    return static_cast<std::size_t>(cells[0] * cells[1] * (dimension == 2 ? 1 : cells[2]));
}

LatticeMapping::LatticeMapping(Lattice const& lattice, LatticeKernel kernel, Border border)
    : lattice_(lattice), kernel_(kernel), border_(border)
{
    check(lattice, kernel);
}

template <int D, LatticeKernel K>
void LatticeMapping::place_all(std::span<double const> position)
{
    constexpr std::int64_t S = support(K);
    Lattice const& l = lattice_;
    double const per_spacing = 1 / l.spacing;
    std::int64_t const stride[3] = {1, l.cells[0], l.cells[0] * l.cells[1]};
    for (std::size_t p = 0; p < first_.size(); ++p) {
        std::int64_t number = 0;
        bool inside = true;
        for (std::size_t a = 0; a < D; ++a) {
            auto const n = static_cast<double>(l.cells[a]);
            double const s = (position[p * D + a] - l.origin[a]) * per_spacing;
            if (!(s >= -1e-9 && s <= n + 1e-9)) {
                inside = false;
                continue;
            }
            AxisWeights<K> w;
            std::int64_t first = axis_weights<K>(std::min(std::max(s, 0.0), n), w);
            if (first < 0 || first + S > l.cells[a]) fold(w, first, l.cells[a], border_);
            std::copy_n(w.data(), S, weight_.data() + (p * D + a) * static_cast<std::size_t>(S));
            number += first * stride[a];
        }
        first_[p] = inside ? number : -1;
        if (!inside) outside_.push_back(p);
    }
}

void LatticeMapping::place(std::span<double const> position)
{
    auto const d = static_cast<std::size_t>(lattice_.dimension);
    need_size("points' positions", position.size(), position.size() / d, lattice_.dimension);
    first_.resize(position.size() / d);
    weight_.resize(position.size() * static_cast<std::size_t>(support(kernel_)));
    outside_.clear();
    dispatch(lattice_.dimension, kernel_,
             [&]<int D, LatticeKernel K>(Constant<D>, KernelConstant<K>) { place_all<D, K>(position); });
    for (std::size_t const p : outside_)
        for (std::size_t a = 0; a < d; ++a)
            require(std::isfinite(position[p * d + a]), [&] {
                return Error("lattice mapping: a position of point " + std::to_string(p) + " is not finite.",
                             Exit::numerical);
            });
}

void LatticeMapping::gather(std::span<double const> at_cells, int width, std::span<double> at_points) const
{
    need_size("cells", at_cells.size(), lattice_.size(), width);
    need_size("points", at_points.size(), points(), width);
    std::int64_t const row = lattice_.cells[0], layer = row * lattice_.cells[1];
    dispatch(lattice_.dimension, kernel_, [&]<int D, LatticeKernel K>(Constant<D>, KernelConstant<K>) {
        constexpr int S = support(K);
        with_width(width, [&]<int W>(Constant<W>) {
            double* out = at_points.data();
            double const* weight = weight_.data();
            for (std::int64_t const first : first_) {
                if (first >= 0) gather_point<D, S, W>(weight, at_cells.data() + first * width, row, layer, width, out);
                weight += D * S;
                out += width;
            }
        });
    });
    for (std::size_t const p : outside_)
        std::fill_n(at_points.data() + p * static_cast<std::size_t>(width), width, 0.0);
}

std::vector<double> LatticeMapping::spread(std::span<double const> at_points, int width,
                                           std::span<double> at_cells) const
{
    need_size("points", at_points.size(), points(), width);
    need_size("cells", at_cells.size(), lattice_.size(), width);
    std::int64_t const row = lattice_.cells[0], layer = row * lattice_.cells[1];
    dispatch(lattice_.dimension, kernel_, [&]<int D, LatticeKernel K>(Constant<D>, KernelConstant<K>) {
        constexpr int S = support(K);
        with_width(width, [&]<int W>(Constant<W>) {
            double const* in = at_points.data();
            double const* weight = weight_.data();
            for (std::int64_t const first : first_) {
                if (first >= 0) spread_point<D, S, W>(weight, at_cells.data() + first * width, row, layer, width, in);
                weight += D * S;
                in += width;
            }
        });
    });
    auto const w = static_cast<std::size_t>(width);
    std::vector<double> lost(w, 0.0);
    for (std::size_t const p : outside_)
        for (std::size_t c = 0; c < w; ++c) lost[c] += at_points[p * w + c];
    return lost;
}

}  // namespace sluice
