#pragma once

#include <cmath>
#include <variant>
#include <vector>

#include "participants/mpm/solver.hpp"

namespace verification {

//! By how much the balance of a run of a law that yields may drift: what the law's books differ by from the work
//! of its stress, which the ledger of points and grid is made with, and rounding. With stress s and elastic energy w
//! before and s', w' after a step, volumes V and V', plastic strain e:
//!
//!     work           (V + V')/2 (turned s + s')/2 : strain
//!     elastic energy (V + V')/2 (w' - w) of it; V' w' - V w is in the balance:   off by (w + w')/2 (V' - V), exactly
//!     dissipated     (V + V')/2 (turned s + s')/2 : e of it; V' s' : e is:       off by at most
//!                    (V' |s' - turned s|/2 + |V' - V|/2 |s'|) |e|
//!
//! |e| is known by the deviatoric plastic strain and the change of the gap, if flow keeps the volume; the turn by the
//! spin of the step.
class LedgerBound
{
 public:
    explicit LedgerBound(mpm::Solver<2> const& solver) : before_(solver.state().points), time_(solver.time()) {}

    void add(mpm::Solver<2> const& solver)
    {
        auto const& now = solver.state().points;
        auto const energy = [&](mpm::Matter const& m) {
            return std::visit([&](auto const& law) { return law.energy(m); }, solver.setup().law);
        };
        double const dt = solver.time() - time_;
        for (std::size_t p = 0; p < now.size(); ++p) {
            mpm::Matter const &a = before_[p].matter, &b = now[p].matter;
            double const grown = now[p].volume_now() - before_[p].volume_now();
            stored_ += 0.5 * (energy(a) + energy(b)) * grown;
            double const spin = std::abs(now[p].slope(0, 1) - now[p].slope(1, 0)) / std::sqrt(2.0);
            double const change = (b.stress - a.stress).norm() + 2 * dt * spin * a.stress.norm();
            double const flow =
                std::sqrt(1.5) * (b.plastic_strain - a.plastic_strain) + std::abs(b.gap - a.gap) / std::sqrt(3.0);
            dissipated_ += 0.5 * (now[p].volume_now() * change + std::abs(grown) * b.stress.norm()) * flow;
        }
        before_ = now, time_ = solver.time();
    }
    double most() const { return std::abs(stored_) + dissipated_; }  //!< [J]

 private:
    std::vector<mpm::Point<2>> before_;
    double time_, stored_ = 0, dissipated_ = 0;
};

}  // namespace verification
