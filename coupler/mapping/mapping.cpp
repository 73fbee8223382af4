#include "coupler/mapping/mapping.hpp"

#include <algorithm>
#include <cassert>
#include <limits>
#include <string>
#include <type_traits>
#include <utility>

#include "coupler/base/error.hpp"

namespace sluice {

namespace {

void need_size(char const* who, char const* what, std::span<double const> values, std::size_t points, int width)
{
    require(width > 0 && values.size() == points * static_cast<std::size_t>(width), [&] {
        return Error(std::string("mapping: ") + who + ": " + std::to_string(values.size()) + " values at the " + what +
                         " (needed: " + std::to_string(points) + " points of " + std::to_string(width) + ").",
                     Exit::internal);
    });
}

//! Calls work(number of components): a constant for 1 to 3, so that the inner loop unrolls.
template <class Work>
void with_width(int width, Work&& work)
{
    switch (width) {
        case 1:
            return work(std::integral_constant<std::size_t, 1>{});
        case 2:
            return work(std::integral_constant<std::size_t, 2>{});
        case 3:
            return work(std::integral_constant<std::size_t, 3>{});
        default:
            return work(static_cast<std::size_t>(width));
    }
}

}  // namespace

Mapping::Mapping(MappingRows rows, std::size_t sources, std::size_t out_of_reach)
    : rows_(std::move(rows)), sources_(sources), out_of_reach_(out_of_reach)
{
    assert(rows_.source.size() == rows_.weight.size() && rows_.begin.back() == rows_.weight.size());
    assert(std::ranges::all_of(rows_.source, [&](auto s) { return s < sources_; }));
    for (std::size_t t = 0; t < targets(); ++t)
        if (rows_.begin[t] == rows_.begin[t + 1]) unmatched_.push_back(t);
}

void Mapping::consistent(std::span<double const> at_sources, int width, std::span<double> at_targets) const
{
    need_size("consistent", "sources", at_sources, sources(), width);
    need_size("consistent", "targets", at_targets, targets(), width);
    with_width(width, [&](auto w) {
        for (std::size_t t = 0; t < targets(); ++t) {
            double* const out = at_targets.data() + t * w;
            std::fill_n(out, std::size_t{w}, 0.0);
            for (std::size_t e = rows_.begin[t]; e < rows_.begin[t + 1]; ++e) {
                double const* const in = at_sources.data() + rows_.source[e] * w;
                for (std::size_t c = 0; c < w; ++c) out[c] += rows_.weight[e] * in[c];
            }
        }
        for (std::size_t const t : unmatched_)
            std::fill_n(at_targets.data() + t * w, std::size_t{w}, std::numeric_limits<double>::quiet_NaN());
    });
}

void Mapping::conservative(std::span<double const> at_targets, int width, std::span<double> at_sources) const
{
    need_size("conservative", "targets", at_targets, targets(), width);
    need_size("conservative", "sources", at_sources, sources(), width);
    std::ranges::fill(at_sources, 0.0);
    with_width(width, [&](auto w) {
        for (std::size_t t = 0; t < targets(); ++t) {
            double const* const in = at_targets.data() + t * w;
            for (std::size_t e = rows_.begin[t]; e < rows_.begin[t + 1]; ++e) {
                double* const out = at_sources.data() + rows_.source[e] * w;
                for (std::size_t c = 0; c < w; ++c) out[c] += rows_.weight[e] * in[c];
            }
        }
    });
}

std::vector<double> Mapping::consistent(std::span<double const> at_sources, int width) const
{
    std::vector<double> at_targets(targets() * static_cast<std::size_t>(std::max(width, 0)));
    consistent(at_sources, width, at_targets);
    return at_targets;
}

std::vector<double> Mapping::conservative(std::span<double const> at_targets, int width) const
{
    std::vector<double> at_sources(sources() * static_cast<std::size_t>(std::max(width, 0)));
    conservative(at_targets, width, at_sources);
    return at_sources;
}

std::vector<double> Mapping::lost(std::span<double const> at_targets, int width) const
{
    need_size("lost", "targets", at_targets, targets(), width);
    auto const w = static_cast<std::size_t>(width);
    std::vector<double> sum(w, 0.0);
    for (std::size_t const t : unmatched_)
        for (std::size_t c = 0; c < w; ++c) sum[c] += at_targets[t * w + c];
    return sum;
}

}  // namespace sluice
