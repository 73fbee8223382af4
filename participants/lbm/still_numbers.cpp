#include "participants/lbm/still_numbers.hpp"

namespace lbm {

template <class Stored>
std::vector<StillRun> StillRowNumbers<Stored>::runs() const
{
    constexpr auto lanes = StillNumbers<Stored>::lanes;
    auto const stride = static_cast<std::ptrdiff_t>(has_solid_.size());
    std::vector<StillRun> runs;
    for (std::ptrdiff_t x = 0; x < stride; ++x) {
        if (!has_solid_[static_cast<std::size_t>(x)]) continue;
        if (runs.empty() || x - runs.back().end >= lanes) runs.push_back({x, x, true, 0});
        runs.back().end = x + 1;
    }
    if (runs.empty() || runs.front().begin + stride - runs.back().end >= lanes) return runs;
    if (runs.size() == 1) return {{0, stride, true, 0}};
    runs.back().end = stride + runs.front().end;
    runs.erase(runs.begin());
    return runs;
}

template <class Stored>
std::vector<Stored> StillRowNumbers<Stored>::numbers(StillRun const& run) const
{
    std::ptrdiff_t const length = StillNumbers<Stored>::length(run), first = run.begin - StillNumbers<Stored>::lanes;
    std::vector<Stored> numbers(static_cast<std::size_t>(still_numbers * length));
    for (std::ptrdiff_t k = 0; k < length; ++k) {
        auto const slot = of_slot(wrap(first + k, static_cast<std::ptrdiff_t>(has_solid_.size())));
        for (std::size_t number = 0; number < slot.size(); ++number)
            numbers[number * static_cast<std::size_t>(length) + static_cast<std::size_t>(k)] =
                static_cast<Stored>(slot[number]);
    }
    return numbers;
}

//! In the order of StillNumber. Where there are no solids those of the fluid, so that it collides there as elsewhere.
template <class Stored>
std::array<double, still_numbers> StillRowNumbers<Stored>::of_slot(std::ptrdiff_t x) const
{
    Relaxation const& r = relaxation_;
    if (!has_solid_[static_cast<std::size_t>(x)]) return {1, 1, 0, les_ ? 0 : r.shear, r.energy, r.square, r.flux};
    double const fraction = row_.fraction[x], push = 2.0 * row_.weight[x], covered = 0.5 * push * fraction;
    auto const rates = rates_beside(r, static_cast<double>(row_.open[x]));
    // odd parts: s (f - j' share) less (1 - s/2) share of the force -2 B j, j' = (1 - B) j
    double const pull = 1 - 2 * covered / (1 - covered) * (1 / rates.flux - 0.5);
    double const shear = les_ && fraction <= eddy_free ? 0 : rates.shear;
    return {1 - covered, pull, push, shear, rates.energy, rates.square, rates.flux};
}

template class StillRowNumbers<double>;
template class StillRowNumbers<float>;

}  // namespace lbm
