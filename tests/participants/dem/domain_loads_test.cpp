#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "coupler/base/error.hpp"
#include "participants/dem/partner_loads.hpp"
#include "tests/participants/dem/domain_runs.hpp"
#include "tests/participants/dem/domain_scenes.hpp"

//! Grains that are shared out, with loads of partners and films of fluid between them.
using unit::alone, unit::shared, unit::without_sums;

namespace {

//! A partner that pushes grains to and fro by their ids, `steps` steps with the same force.
template <int D>
struct Push
{
    double force;  //!< [N]
    int steps;

    std::vector<dem::Load<D>> at(std::size_t grains, int n) const
    {
        std::vector<dem::Load<D>> loads(grains);
        double const phase = 0.01 * (n / steps);
        for (std::size_t i = 0; i < grains; ++i) {
            auto& load = loads[i];
            load.force.x = force * std::sin(static_cast<double>(i) + phase);
            load.force.y = force * std::cos(2.0 * static_cast<double>(i) - phase);
            dem::each_number(load.torque, [&](double& t) { t = 1e-4 * force * std::cos(phase); });
        }
        return loads;
    }
    //! Sets them before a step: of several processes only the first knows them.
    unit::Before<D> before(std::size_t grains) const
    {
        return [*this, grains](dem::Solver<D>& solver, int n) {
            bool const first = !solver.domain() || solver.domain()->is_first();
            if (n % steps == 0) solver.set_loads(first ? at(grains, n) : std::vector<dem::Load<D>>{});
        };
    }
};

dem::Solver<2> pushed_discs(bool ledger)
{
    return {unit::setup(0.5, {0.0, 0.0}, ledger), unit::loose(12, 5, 0.3)};
}

template <int D>
dem::Solver<D> filmy(dem::Solver<D> const& dry)
{
    dem::Setup<D> s = dry.setup();
    s.lubrication = {.viscosity = 0.02, .cutoff = 2e-4, .floor = 1e-2};
    s.skin += s.lubrication.cutoff;
    return {s, dry.grains()};
}

void check_ledger(dem::Setup<2> const& setup, dem::State<2> const& many, dem::State<2> const& one)
{
    auto const ours = dem::energies(setup, many), theirs = dem::energies(setup, one);
    REQUIRE(theirs.external_work != 0.0);
    // the terms of a sum are added up in another order: of 1e6 terms, relative to all that was moved
    double const scale = std::abs(theirs.external_work) + theirs.lost();
    for (auto const part : {&dem::Energies::normal_dashpot, &dem::Energies::external_work, &dem::Energies::wall_work})
        CHECK(std::abs(ours.*part - theirs.*part) < 1e-12 * scale);
    CHECK(ours.kinetic() == theirs.kinetic());
}

}  // namespace

TEST_CASE("domain: discs under a partner's loads are the same to the last bit on 1, 2, 3 and 5 processes")
{
    int const steps = 6000;
    auto const start = pushed_discs(true);
    for (int const held : {1, 100}) {  // steps; with 100 grains migrate while nothing is dealt
        CAPTURE(held);
        auto const push = Push<2>{0.5, held}.before(144);
        auto const one = alone(start, steps, unit::step, push);
        REQUIRE(one.rebuilds > 20);
        for (int const processes : {1, 2, 3, 5}) {
            CAPTURE(processes);
            auto const many = shared(start, processes, steps, unit::step, push);
            CHECK(without_sums(many.whole) == without_sums(one));
            if (processes > 1) CHECK(many.migrated > 0);
            check_ledger(start.setup(), many.whole, one);
        }
        CHECK(without_sums(alone(start, steps, unit::step)) != without_sums(one));  // they do push
    }
}

TEST_CASE("domain: spheres with torques of a partner, in packs of four contacts and with threads")
{
    auto const start = unit::tumbling(dem::Rolling::constant, dem::Scheme::predicted, false);
    auto const push = Push<3>{0.05, 40}.before(start.grains().size());
    auto const one = without_sums(alone(start, 3000, 1e-5, push));
    dem::Setup<3> setup = start.setup();
    setup.threads = 2;
    CHECK(without_sums(shared(start, 3, 3000, 1e-5, push).whole) == one);
    CHECK(without_sums(shared(dem::Solver<3>(setup, start.grains()), 2, 3000, 1e-5, push).whole) == one);
}

TEST_CASE("domain: ghosts have the load of their originals")
{
    auto const start = pushed_discs(false);
    auto const push = Push<2>{0.5, 50};
    unit::on_processes(3, [&](ranks::Peers& peers) {
        dem::Solver<2> solver = peers.rank() == 0 ? start : dem::Solver<2>(start.setup(), {});
        solver.share_out(peers);
        std::int64_t ghosts = 0, rebuilds = solver.state().rebuilds, wrong = 0;
        for (int n = 0; n < 3000; ++n) {
            push.before(144)(solver, n);
            solver.step(unit::step);
            auto const expected = push.at(144, n / 50 * 50);
            auto const& g = solver.grains();
            for (std::size_t i = 0; i < g.size(); ++i) {
                auto const& load = expected[static_cast<std::size_t>(g.id[i])];
                wrong += g.external[i].force.x != load.force.x || g.external[i].torque != load.torque;
                ghosts += g.is_ghost(i);
            }
        }
        auto const all = ranks::sums(peers, {ghosts, wrong, solver.state().rebuilds - rebuilds});
        if (peers.rank() > 0) return;
        CHECK(all[0] > 3000);
        CHECK(all[1] == 0);
        CHECK(all[2] > 0);
    });
}

TEST_CASE("domain: where all grains are and how they move comes to the first process without the rest")
{
    auto const start = unit::collapse();
    unit::on_processes(3, [&](ranks::Peers& peers) {
        dem::Solver<2> solver = peers.rank() == 0 ? start : dem::Solver<2>(start.setup(), {});
        solver.share_out(peers);
        auto all = solver.whole().grains;
        std::size_t moved = 0;
        for (int n = 0; n < 4000; ++n) {
            solver.step(unit::step);
            if (n % 500 != 0) continue;
            auto const before = all.place;
            solver.gather_motion(all);
            auto const whole = solver.whole().grains;
            if (peers.rank() > 0) continue;
            REQUIRE(all.size() == 144);
            for (std::size_t i = 0; i < all.size(); ++i) {
                CHECK(all.place[i].centre == whole.place[i].centre);
                CHECK(all.motion[i].velocity == whole.motion[i].velocity);
                CHECK(all.motion[i].spin == whole.motion[i].spin);
                moved += before[i].centre != all.place[i].centre;
            }
        }
        if (peers.rank() == 0) CHECK(moved > 144);
    });
}

TEST_CASE("domain: films of fluid are the same to the last bit on several processes, their losses booked once")
{
    auto const discs = filmy(unit::collapse(true));
    auto const push = Push<2>{0.2, 20}.before(144);
    auto const one = alone(discs, 6000, unit::step, push);
    REQUIRE(one.films.size() > 20);
    for (int const processes : {2, 3, 5}) {
        CAPTURE(processes);
        auto const many = shared(discs, processes, 6000, unit::step, push);
        CHECK(without_sums(many.whole) == without_sums(one));
        CHECK(many.migrated > 0);
        check_ledger(discs.setup(), many.whole, one);
    }
    auto const spheres = filmy(unit::tumbling(dem::Rolling::elastic_plastic, dem::Scheme::predicted, false));
    CHECK(without_sums(shared(spheres, 3, 3000, 1e-5).whole) == without_sums(alone(spheres, 3000, 1e-5)));
}

TEST_CASE("partner loads: sums by id, and a grain that is not there is refused")
{
    for (std::int64_t const far : {12, 1'000'000}) {  // ids close together and far apart: a table, a map
        dem::PartnerLoads<2> loads({far, 4, 7});
        std::vector<std::int64_t> const id{7, far}, other{4}, foreign{5};
        std::vector<double> const force{1.0, 2.0, 3.0, 4.0}, torque{0.5, -0.5}, weak{0.25, 0.0}, still{0.0};
        loads.take({{id, force, torque}, {id, force, torque}, {other, weak, still}});
        CHECK(loads.on_grains()[0].force == dem::Vec2{6.0, 8.0});
        CHECK(loads.on_grains()[1].force == dem::Vec2{0.25, 0.0});
        CHECK(loads.on_grains()[2].torque == 1.0);
        CHECK(loads.force() == dem::Vec2{8.25, 12.0});
        loads.take({{other, weak, still}});
        CHECK(loads.on_grains()[0].force == dem::Vec2{});
        loads.take({{other, weak, {}}, {id, force, torque}});  // one of them knows no torque
        CHECK(loads.on_grains()[1].force == dem::Vec2{0.25, 0.0});
        CHECK(loads.on_grains()[1].torque == 0.0);
        CHECK(loads.on_grains()[2].torque == 0.5);
        CHECK_THROWS_WITH_AS(loads.take({{foreign, weak, still}}), "a load on grain 5, which is none of the 3 grains.",
                             sluice::Error);
    }
}
