#pragma once

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "participants/mpm/law_config.hpp"
#include "participants/mpm/solver.hpp"
#include "tests/support/verification.hpp"

namespace verification {

//! By how much the balance of a run of a law that yields has to drift: what the books of the law differ by from the
//! work of its stress, which the ledger of points and grid is made with. With stress s and elastic energy w before and
//! s', w' after a step, volumes V and V', and the strain that no stress follows, e = strain - C^-1 (s' - turned s):
//!
//!     work           (V + V')/2 (turned s + s')/2 : strain
//!     elastic energy (V + V')/2 (w' - w) of it; V' w' - V w is in the balance:   off by (w + w')/2 (V' - V)
//!     dissipated     (V + V')/2 (turned s + s')/2 : e of it; V' s' : e is booked: off by the difference
//!
//! exactly. Turn and strain are those of F' F^-1, which rounding is off by, times the stress.
class LedgerDrift
{
 public:
    explicit LedgerDrift(mpm::Solver<2> const& solver)
        : before_(solver.state().points), balance_(solver.energies().balance())
    {}

    void add(mpm::Solver<2> const& solver)
    {
        auto const& now = solver.state().points;
        auto const elastic = mpm::elasticity_of(solver.setup().law);
        for (std::size_t p = 0; p < now.size(); ++p) {
            mpm::Matter const &a = before_[p].matter, &b = now[p].matter;
            double const old_volume = before_[p].volume_now(), volume = now[p].volume_now();
            mpm::Mat3 const back = a.gradient.inverse();
            mpm::Increment const step(b.gradient * back);
            mpm::Mat3 const turned = step.turned(a.stress), flow = step.strain - elastic.strain(b.stress - turned);
            explained_ += 0.5 * (elastic.energy(a.stress) + elastic.energy(b.stress)) * (volume - old_volume) +
                          mpm::contract(volume * b.stress - 0.25 * (old_volume + volume) * (turned + b.stress), flow);
            rounding_ +=
                std::numeric_limits<double>::epsilon() * (volume * b.stress.norm() * b.gradient.norm() * back.norm() +
                                                          0.5 * now[p].mass * now[p].velocity.squaredNorm());
        }
        before_ = now;
    }
    struct Result
    {
        double seen = 0;         //!< drift since the start
        double unexplained = 0;  //!< of it by the books
        double rounding = 0;     //!< at most, of that
    };
    //! All by what was dissipated [-].
    Result result(mpm::Solver<2> const& solver) const
    {
        auto const e = solver.energies();
        double const drift = e.balance() - balance_;
        return {std::abs(drift) / e.lost(), std::abs(drift - explained_) / e.lost(), rounding_ / e.lost()};
    }

 private:
    std::vector<mpm::Point<2>> before_;
    double balance_, explained_ = 0, rounding_ = 0;  // [J]
};

//! Marks: 1 % of what was dissipated, as of other balances; and rounding, of what the books do not explain.
inline void check_ledger(char const* id, std::string const& name, LedgerDrift::Result const& r, double seconds)
{
    CHECK(report({id, name + "drift of the ledger, by what was dissipated", r.seen, 0, r.seen, 0.01, seconds}));
    CHECK(
        report({id, name + "of it not in the books of the law", r.unexplained, 0, r.unexplained, r.rounding, seconds}));
}

}  // namespace verification
