#pragma once

#include <cstdint>
#include <functional>
#include <set>
#include <type_traits>
#include <utility>
#include <vector>

#include "participants/dem/domain.hpp"
#include "participants/dem/solver.hpp"
#include "tests/support/thread_peers.hpp"

//! The same run by one process and by several.
namespace unit {

//! What a shared run came to, and what happened on the way.
template <int D>
struct Ending
{
    dem::State<D> whole;
    std::int64_t slab_moves = 0;
    std::size_t migrated = 0;        //!< grains that another process has at the end than at the start
    std::vector<std::size_t> owned;  //!< by process, at the end
};

template <int D>
std::set<std::int64_t> own_ids(dem::Solver<D> const& solver)
{
    std::set<std::int64_t> ids;
    for (std::size_t i = 0; i < solver.grains().size(); ++i)
        if (!solver.grains().is_ghost(i)) ids.insert(solver.grains().id[i]);
    return ids;
}

//! What all processes do before step n.
template <int D>
using Before = std::function<void(dem::Solver<D>&, int n)>;

template <int D>
void advance(dem::Solver<D>& solver, int steps, double dt, Before<D> const& prepare)
{
    for (int n = 0; n < steps; ++n) {
        if (prepare) prepare(solver, n);
        solver.step(dt);
    }
}

//! `steps` steps by `processes` from where a run of one process stands.
template <int D>
Ending<D> shared(dem::Solver<D> const& from, int processes, int steps, double dt,
                 std::type_identity_t<Before<D>> const& prepare = {})
{
    Ending<D> ending;
    ending.owned.resize(static_cast<std::size_t>(processes));
    unit::on_processes(processes, [&](ranks::Peers& peers) {
        dem::Solver<D> solver = peers.rank() == 0 ? from : dem::Solver<D>(from.setup(), {});
        solver.share_out(peers);
        auto const before = own_ids(solver);
        advance(solver, steps, dt, prepare);
        auto whole = solver.whole();
        auto const after = own_ids(solver);
        std::int64_t came = 0;
        for (auto const id : after) came += !before.contains(id);
        came = ranks::sums(peers, {came})[0];
        ending.owned[static_cast<std::size_t>(peers.rank())] = after.size();
        if (peers.rank() != 0) return;
        ending.migrated = static_cast<std::size_t>(came);
        ending.whole = std::move(whole);
        ending.slab_moves = solver.domain()->moves();
    });
    return ending;
}

template <int D>
dem::State<D> alone(dem::Solver<D> solver, int steps, double dt, std::type_identity_t<Before<D>> const& prepare = {})
{
    advance(solver, steps, dt, prepare);
    return solver.state();
}

}  // namespace unit
