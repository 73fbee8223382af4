#pragma once

#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "participants/mpm/measures.hpp"
#include "participants/mpm/setup.hpp"
#include "tests/verification/mpm/bars.hpp"
#include "tests/verification/mpm/ledger_drift.hpp"

namespace verification {

struct Collapse
{
    double run_out;   //!< (L - L0)/L0 at a depth of 5 % of the root of its area, once it has come to rest
    double foremost;  //!< the same of the foremost point
    double swing;     //!< by which the pressures within a cell differ from their mean, by the mean of all (rms)
    LedgerDrift::Result ledger;
};

inline double swing(mpm::Solver<2> const& solver)
{
    std::map<std::pair<int, int>, std::pair<double, int>> cells;
    auto const cell_of = [&](auto const& p) {
        return std::pair(int(p.place[0] / solver.setup().cell), int(p.place[1] / solver.setup().cell));
    };
    auto const pressure = [](auto const& p) { return -p.matter.stress.trace() / 3; };
    double all = 0, squares = 0;
    for (auto const& p : solver.state().points) {
        all += pressure(p);
        cells[cell_of(p)].first += pressure(p);
        ++cells[cell_of(p)].second;
    }
    for (auto const& p : solver.state().points)
        squares += std::pow(pressure(p) - cells[cell_of(p)].first / cells[cell_of(p)].second, 2);
    auto const count = static_cast<double>(solver.state().points.size());
    return std::sqrt(squares / count) / (all / count);
}

//! The column of configs/mpm_column.yaml, 0.1 m wide.
struct Column
{
    static constexpr double width = 0.1;  // m
    double aspect_ratio;
    int cells_across;
    bool shared_volume = true;
    mpm::BasisKind basis = mpm::BasisKind::gimp;
    double friction_angle = 23;  // degrees
    bool rough_back = false;     //!< the back wall is as the floor, not a roller

    double height() const { return aspect_ratio * width; }
    mpm::Solver<2> solver() const
    {
        mpm::Elasticity const elastic{1.98e6, 0.23};
        mpm::MohrCoulombParameters const grains{.friction_angle = friction_angle * std::numbers::pi / 180};
        mpm::Config c;
        c.cell = width / cells_across;
        c.size = {width * (2 + std::ceil(3 * aspect_ratio)), c.cell * std::ceil(height() / c.cell + 2), 0};
        c.gravity = {0, -9.81, 0};
        c.density = 1925;
        c.law = mpm::MohrCoulomb{elastic, mpm::MohrCoulombSurface(elastic, grains)};
        c.bodies.push_back({.high = {width, height(), 0}});
        mpm::Wall const floor{.axis = 1, .side = -1, .kind = mpm::WallKind::rough, .friction = 0.466};
        c.walls = {{.axis = 0, .side = -1}, floor};
        if (rough_back) c.walls[0].kind = floor.kind, c.walls[0].friction = floor.friction;
        c.geostatic = mpm::GeostaticConfig{.surface = height(), .k0 = 0.23 / 0.77};
        c.shared_volume = shared_volume;
        c.basis = basis;
        return mpm::make_solver<2>(c);
    }
    //! Until it has come to rest; each_step() after every step.
    template <class EachStep>
    void let_go(mpm::Solver<2>& solver, EachStep&& each_step) const
    {
        while (solver.time() < 7 * std::sqrt(height() / 9.81)) {
            solver.step(solver.longest_step());
            each_step();
        }
    }
    mpm::RunOut run_out(mpm::Solver<2> const& solver) const
    {
        return mpm::run_out_of(solver.setup(), solver.state(), 0.05 * std::sqrt(width * height()));
    }
};

inline Collapse collapse(double aspect_ratio, int cells_across, bool shared_volume = true)
{
    Column const column{aspect_ratio, cells_across, shared_volume};
    auto solver = column.solver();
    LedgerDrift drift(solver);
    column.let_go(solver, [&] { drift.add(solver); });
    auto const r = column.run_out(solver);
    return {r.front / Column::width - 1, r.foremost / Column::width - 1, swing(solver), drift.result(solver)};
}

}  // namespace verification
