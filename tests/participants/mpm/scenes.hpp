#pragma once

#include <array>
#include <cstddef>
#include <variant>
#include <vector>

#include "participants/mpm/config.hpp"
#include "participants/mpm/solver.hpp"
#include "participants/mpm/state.hpp"

namespace unit {

//! An elastic block in a domain of `size` each way, in cells of 0.1 m.
template <int D>
mpm::Config box(double size, std::array<double, 3> low, std::array<double, 3> high)
{
    mpm::Config c;
    c.dimension = D;
    for (std::size_t k = 0; k < D; ++k) c.size[k] = size;
    c.cell = 0.1;
    c.density = 1000;
    c.law = mpm::LinearElastic{{1e5, 0.3}};
    c.bodies.push_back({.low = low, .high = high});
    return c;
}

template <int D>
mpm::Vec<D> momentum(mpm::State<D> const& state)
{
    mpm::Vec<D> sum = mpm::Vec<D>::Zero();
    for (auto const& p : state.points) sum += p.mass * p.velocity;
    return sum;
}

//! What the balance of a linear elastic body gains, for its energy w, by the volume now, is one of the stress now [J]:
//! a step works (V + V')/2 (w' - w), but V' w' - V w is there, (w + w')/2 (V' - V) more. To rounding.
class GainOfVolume
{
 public:
    explicit GainOfVolume(mpm::Solver<2> const& solver) : before_(solver.state().points) {}
    void add(mpm::Solver<2> const& solver)
    {
        auto const& law = std::get<mpm::LinearElastic>(solver.setup().law);
        for (std::size_t p = 0; p < before_.size(); ++p) {
            auto const& now = solver.state().points[p];
            double const density = 0.5 * (law.energy(before_[p].matter) + law.energy(now.matter));
            sum_ += density * (now.volume_now() - before_[p].volume_now());
        }
        before_ = solver.state().points;
    }
    double sum() const { return sum_; }

 private:
    std::vector<mpm::Point<2>> before_;
    double sum_ = 0;
};

}  // namespace unit
