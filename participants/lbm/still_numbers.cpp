#include "participants/lbm/still_numbers.hpp"

namespace lbm {
namespace {

template <class Stored>
std::array<double, still_numbers> of_solid(SolidRow<Stored> const& row, std::ptrdiff_t x, Relaxation const& r, bool les)
{
    double const fraction = row.fraction[x], push = 2.0 * row.weight[x], covered = 0.5 * push * fraction;
    auto const rates = rates_beside(r, static_cast<double>(row.open[x]));
    // odd parts: s (f - j' share) less (1 - s/2) share of the force -2 B j, j' = (1 - B) j
    double const pull = 1 - 2 * covered / (1 - covered) * (1 / rates.flux - 0.5);
    double const shear = les && fraction <= eddy_free ? 0 : rates.shear;
    return {1 - covered, pull, push, shear, rates.energy, rates.square, rates.flux};
}

}  // namespace

template <class Stored>
typename StillRowNumbers<Stored>::OfCell StillRowNumbers<Stored>::of_fluid(Relaxation const& r, bool les) noexcept
{
    return {1, 1, 0, les ? 0 : r.shear, r.energy, r.square, r.flux};
}

template <class Stored>
StillRowNumbers<Stored>::StillRowNumbers(SolidRow<Stored> const& row, std::vector<char> has_solid,
                                         Relaxation const& relaxation, bool les)
    : has_solid_(std::move(has_solid)), of_cell_(has_solid_.size(), of_fluid(relaxation, les))
{
    for (std::size_t x = 0; x < of_cell_.size(); ++x)
        if (has_solid_[x]) of_cell_[x] = of_solid(row, static_cast<std::ptrdiff_t>(x), relaxation, les);
}

template <class Stored>
std::vector<StillRun> StillRowNumbers<Stored>::runs() const
{
    std::vector<StillRun> runs;
    for (std::ptrdiff_t x = 0; x < cells(); ++x) {
        if (!has_solid_[static_cast<std::size_t>(x)]) continue;
        if (runs.empty() || x - runs.back().end >= StillNumbers<Stored>::lanes) runs.push_back({x, x, true, 0});
        runs.back().end = x + 1;
    }
    return runs;
}

template class StillRowNumbers<double>;
template class StillRowNumbers<float>;

}  // namespace lbm
