#pragma once

#include <string>
#include <utility>
#include <vector>

#include "coupler/base/state.hpp"
#include "participants/dem/solver.hpp"

namespace dem {

//! The steady part of a sheared cell's run: means and spreads (standard deviations) over samples from a strain on.
class SteadyShear
{
 public:
    template <int D>
    void sample(Solver<D> const& solver);

    //! Friction angles by the stress tensor and by shear over normal stress, packing fraction, inertial number
    //! d rate sqrt(rho / normal stress), with names and units; nothing before the steady part.
    std::vector<std::pair<std::string, double>> facts() const;

    void keep(sluice::State& state) const;
    static SteadyShear kept(sluice::State const& state);

 private:
    struct Mean
    {
        double sum = 0.0, squares = 0.0;
        void add(double value) { sum += value, squares += value * value; }
    };
    double count_ = 0.0, strain_ = 0.0;
    Mean angle_, ratio_, normal_, fraction_, inertial_;
};

}  // namespace dem
