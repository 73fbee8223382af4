// PackedStep: contact of the points of all processes with grains and plates. There are few contacts, which act on one
// another: each process knows all of them and does the same.
#include <optional>

#include "participants/mpm/packed_step.hpp"

namespace mpm {
namespace {

//! A point that may touch a grain or plate.
template <int D>
struct Candidate
{
    std::int64_t id;
    std::array<double, D> place;
    double ratio;
};

}  // namespace

template <int D>
void PackedStep<D>::touch_grains(Given const& now, GrainContacts<D>& grains, Outcome& outcome)
{
    using C = PackedColumns<D>;
    auto const vector = [](std::array<double, D> const& numbers) -> Vec<D> {
        return Eigen::Map<Vec<D> const>(numbers.data());
    };
    grains.begin(now.setup);
    std::vector<Candidate<D>> near;
    for (std::size_t k = 0; k < points_.size(); ++k) {
        Candidate<D> c{points_.order()[k], {}, points_[C::ratio][k]};
        for (std::size_t a = 0; a < D; ++a) c.place[a] = points_[C::place + a][k];
        if (grains.is_near(now.setup, vector(c.place))) near.push_back(c);
    }
    if (peers_) near = ranks::all_rows(*peers_, near);
    for (auto const& c : near) grains.consider(now.setup, now.dt, c.id, vector(c.place), c.ratio);
    nodes_.show(grains.nodes());
    if (peers_) share_touched(grains.nodes());
    grains.solve(now.setup, now.time, now.dt, outcome.booked);
    nodes_.take(grains.nodes());
}

//! Each is told by the first process that has it. What no process has, a face that lies on a line of nodes reaches by
//! rounding alone: it keeps mass 0.
template <int D>
void PackedStep<D>::share_touched(std::span<TouchedNode<D>> touched) const
{
    auto const& boxes = borders_.nodes();
    auto const teller = [&](TouchedNode<D> const& node) -> std::optional<std::size_t> {
        auto const found = std::ranges::find_if(boxes, [&](NodeBox<D> const& box) { return box.has(node.index); });
        if (found == boxes.end()) return std::nullopt;
        return static_cast<std::size_t>(found - boxes.begin());
    };
    auto const own = static_cast<std::size_t>(shares_.rank());
    std::vector<double> told;
    for (TouchedNode<D> const& node : touched) {
        if (teller(node) != own) continue;
        told.push_back(node.mass);
        for (Vec<D> const* v : {&node.before, &node.velocity}) told.insert(told.end(), v->data(), v->data() + D);
    }
    auto const all = ranks::of_everyone(*peers_, told);
    std::vector<double const*> next;
    for (auto const& numbers : all) next.push_back(numbers.data());
    for (TouchedNode<D>& node : touched) {
        auto const from = teller(node);
        if (!from) continue;
        double const*& at = next[*from];
        node.mass = *at++;
        for (Vec<D>* v : {&node.before, &node.velocity}) {
            *v = Eigen::Map<Vec<D> const>(at);
            at += D;
        }
    }
}

template void PackedStep<2>::touch_grains(Given const&, GrainContacts<2>&, Outcome&);
template void PackedStep<3>::touch_grains(Given const&, GrainContacts<3>&, Outcome&);
template void PackedStep<2>::share_touched(std::span<TouchedNode<2>>) const;
template void PackedStep<3>::share_touched(std::span<TouchedNode<3>>) const;

}  // namespace mpm
