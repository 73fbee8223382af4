#include "participants/mpm/checkpoint.hpp"

#include <cmath>
#include <span>
#include <vector>

#include "coupler/base/error.hpp"

namespace mpm {
namespace {

using sluice::Error;
using sluice::require;

//! Numbers of each point: calls each(name, how many, where they lie).
template <int D, class Each>
void each_column(Each&& each)
{
    each("points/place", D, [](auto& p) { return p.place.data(); });
    each("points/velocity", D, [](auto& p) { return p.velocity.data(); });
    each("points/slope", D * D, [](auto& p) { return p.slope.data(); });
    each("points/mass", 1, [](auto& p) { return &p.mass; });
    each("points/volume", 1, [](auto& p) { return &p.volume; });
    each("points/gradient", 9, [](auto& p) { return p.matter.gradient.data(); });
    each("points/ratio", 1, [](auto& p) { return &p.matter.ratio; });
    each("points/stress", 9, [](auto& p) { return p.matter.stress.data(); });
    each("points/plastic_strain", 1, [](auto& p) { return &p.matter.plastic_strain; });
    each("points/gap", 1, [](auto& p) { return &p.matter.gap; });
}

//! An edge of a point's domain that F leaves no length has no direction (half_edges()).
template <int D>
bool has_edges(Mat3 const& gradient)
{
    return gradient.allFinite() && gradient.topLeftCorner<D, D>().colwise().norm().minCoeff() > 0;
}

template <int D>
void require_usable(Solver<D> const& solver, State<D> const& state)
{
    for (Point<D> const& p : state.points) {
        bool const usable = solver.contains(p.place) && p.mass > 0 && p.volume > 0 && p.matter.ratio > 0 &&
                            std::isfinite(p.mass + p.volume) && std::isfinite(p.matter.ratio) &&
                            std::isfinite(p.matter.plastic_strain + p.matter.gap) && has_edges<D>(p.matter.gradient) &&
                            p.matter.stress.allFinite() && p.velocity.allFinite() && p.slope.allFinite();
        require(usable, [&] {
            return Error("mpm: the checkpoint has a point " + std::to_string(p.id) +
                             " that no run has (needs numbers, a place in the domain). Resume from an older one.",
                         sluice::Exit::io);
        });
    }
}

//! What the first process has kept.
sluice::State known_to_all(ranks::Peers* peers, sluice::State const& own)
{
    if (!peers) return own;
    auto const encoded = peers->rank() == 0 ? own.encode() : ranks::Bytes{};
    return sluice::State::decode(ranks::much_from_first(*peers, encoded), "the first process's checkpoint");
}

}  // namespace

template <int D>
void keep(Solver<D> const& solver, sluice::State& kept)
{
    State<D> const& state = solver.state();
    if (solver.peers() && solver.peers()->rank() > 0) return;
    std::vector<std::int64_t> ids;
    for (Point<D> const& p : state.points) ids.push_back(p.id);
    kept.put("points/id", std::span<std::int64_t const>(ids));
    std::vector<std::int64_t> order(state.order.begin(), state.order.end());
    for (std::size_t p = order.size(); p < ids.size(); ++p) order.push_back(static_cast<std::int64_t>(p));
    kept.put("points/order", std::span<std::int64_t const>(order));
    each_column<D>([&](char const* name, std::size_t count, auto at) {
        std::vector<double> values;
        for (Point<D> const& p : state.points) values.insert(values.end(), at(p), at(p) + count);
        kept.put(name, std::span<double const>(values));
    });
    Booked const& b = state.booked;
    kept.put("booked",
             std::vector<double>{b.plastic, b.sliding, b.damping, b.numerical, b.external_work, b.field_work});
    kept.put_number("time", state.time);
    kept.put_integer("steps", state.steps);
    kept.put_number("speed", solver.speed());
    kept.put_integer("light_nodes", solver.light_nodes());
}

template <int D>
void restore(Solver<D>& solver, sluice::State const& own)
{
    auto const kept = known_to_all(solver.peers(), own);
    State<D> state;
    auto const ids = kept.integers("points/id", solver.count());
    state.points.resize(ids.size());
    for (std::size_t p = 0; p < ids.size(); ++p) state.points[p].id = ids[p];
    auto const order = kept.integers("points/order", ids.size());
    state.order.assign(ids.size(), -1);
    std::vector<bool> met(ids.size(), false);
    for (std::size_t p = 0; p < ids.size(); ++p) {
        auto const at = static_cast<std::size_t>(order[p]);
        require(at < ids.size() && !met[at], [] {
            return Error("mpm: points/order of the checkpoint is no order of its points. Resume from an older one.",
                         sluice::Exit::io);
        });
        met[at] = true;
        state.order[p] = static_cast<std::int32_t>(order[p]);
    }
    each_column<D>([&](char const* name, std::size_t count, auto at) {
        auto const values = kept.numbers(name, count * ids.size());
        for (std::size_t p = 0; p < ids.size(); ++p) std::copy_n(values.data() + count * p, count, at(state.points[p]));
    });
    auto const booked = kept.numbers("booked", 6);
    state.booked = {booked[0], booked[1], booked[2], booked[3], booked[4], booked[5]};
    state.time = kept.number("time");
    state.steps = kept.integer("steps");
    require_usable(solver, state);
    double const speed = kept.number("speed");
    require(speed > 0 && std::isfinite(speed), [] {
        return Error("mpm: speed of the checkpoint is none (needs a number above 0). Resume from an older one.",
                     sluice::Exit::io);
    });
    std::int64_t const light_nodes = kept.integer("light_nodes");
    solver.restore(std::move(state), speed);
    solver.count_light_nodes_from(light_nodes);
}

template void keep<2>(Solver<2> const&, sluice::State&);
template void keep<3>(Solver<3> const&, sluice::State&);
template void restore<2>(Solver<2>&, sluice::State const&);
template void restore<3>(Solver<3>&, sluice::State const&);

}  // namespace mpm
