#include "participants/dem/mesh_contacts.hpp"

#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "coupler/base/error.hpp"

namespace dem {
namespace {

//! A facet that overlaps: its entry, and the place in the list of those of the contact that it is part of.
struct Overlapping
{
    std::size_t entry;
    std::size_t root = 0;
};

//! The contacts of one grain with one mesh. Kept from grain to grain for its memory.
template <int D>
class FeetOfGrain
{
 public:
    //! The entries `begin` to `end` are those of a grain of this radius [m].
    void look(WallContacts<D>& contacts, std::size_t begin, std::size_t end, double radius)
    {
        gather(contacts.foot, begin, end, radius);
        for (std::size_t n = 0; n < overlapping_.size(); ++n) {
            overlapping_[n].root = root_of(contacts.foot, n, radius);
            contacts.foot[overlapping_[n].entry].bears = overlapping_[n].root == n;
        }
        for (std::size_t k = begin; k < end; ++k)
            if (contacts.foot[k].bore && !contacts.foot[k].bears) hand_over(contacts, k, radius);
    }

 private:
    void gather(std::vector<Foot<D>> const& foot, std::size_t begin, std::size_t end, double radius)
    {
        overlapping_.clear();
        for (std::size_t k = begin; k < end; ++k)
            if (foot[k].at.distance < radius) overlapping_.push_back({k});
        auto const place = [&](Overlapping const& one) { return std::pair(foot[one.entry].at.distance, one.entry); };
        std::sort(overlapping_.begin(), overlapping_.end(),
                  [&](Overlapping const& a, Overlapping const& b) { return place(a) < place(b); });
    }

    //! Of the nearer ones whose cap it is in, that of the direction most like its own decides.
    std::size_t root_of(std::vector<Foot<D>> const& foot, std::size_t n, double radius) const
    {
        Facing<D> const& own = foot[overlapping_[n].entry].at;
        std::size_t root = n;
        double closest = -1.0;
        for (std::size_t m = 0; m < n; ++m) {
            Facing<D> const& nearer = foot[overlapping_[m].entry].at;
            double const cosine = dot(own.normal, nearer.normal);
            if (cosine * radius < nearer.distance || cosine <= closest) continue;
            closest = cosine;
            root = overlapping_[m].root;
        }
        return root;
    }

    //! A contact that has left its facet goes on in the contact that the facet is part of now. Where it merges with one
    //! that was there before, its history ends.
    void hand_over(WallContacts<D>& contacts, std::size_t from, double radius) const
    {
        std::size_t const to = heir_of(contacts.foot, from, radius);
        if (to == from || contacts.foot[to].bore || is_taken(contacts.history, to)) return;
        auto const move = [&](auto& kept) {
            if (kept.empty()) return;
            kept[to] = kept[from];
            kept[from] = {};
        };
        move(contacts.history.friction);
        move(contacts.history.rolling);
    }

    //! The entry that bears in place of this one, or this one. A facet that was left within the step, and overlaps no
    //! more, is part of a contact on whose plane or behind it its nearest point lies, up to that one's overlap.
    std::size_t heir_of(std::vector<Foot<D>> const& foot, std::size_t from, double radius) const
    {
        Facing<D> const& old = foot[from].at;
        double closest = -1.0;
        std::size_t heir = from;
        for (Overlapping const& one : overlapping_) {
            if (one.entry == from) return overlapping_[one.root].entry;
            Facing<D> const& now = foot[one.entry].at;
            double const cosine = dot(old.normal, now.normal);
            if (!foot[one.entry].bears || cosine <= closest) continue;
            if (cosine * old.distance * radius < now.distance * now.distance) continue;
            closest = cosine;
            heir = one.entry;
        }
        return heir;
    }

    static bool is_taken(History<D> const& history, std::size_t entry)
    {
        return (!history.friction.empty() && history.friction[entry] != Tangent<D>{}) ||
               (!history.rolling.empty() && history.rolling[entry] != Tangent<D>{});
    }

    std::vector<Overlapping> overlapping_;  //!< by distance
};

template <int D>
void find_feet_on(Mesh<D> const& mesh, Wall<D> const& wall, State<D> const& state, WallContacts<D>& contacts, double dt)
{
    Grains<D> const& g = state.grains;
    Vec<D> const wall_step = contacts.shift - wall.motion.shift(state.time);
    FeetOfGrain<D> feet;
    for (std::size_t begin = 0, end = 0; begin < contacts.grain.size(); begin = end) {
        std::size_t const i = contacts.grain[begin];
        auto const& [centre, radius] = g.place[i];
        Vec<D> const step = dt > 0.0 ? dt * g.half[i].velocity - wall_step : Vec<D>{};
        double const square = dot(step, step);
        for (; end < contacts.grain.size() && contacts.grain[end] == i; ++end) {
            Facing<D> const at = mesh.facets->facets()[contacts.facet[end]].facing(centre - contacts.shift);
            Foot<D>& foot = contacts.foot[end];
            foot = {at, foot.at, false, foot.bears};
            sluice::require(!(at.distance * at.distance <= square) || dt == 0.0, [&] {
                return sluice::Error(
                    "dem: the centre of grain " + std::to_string(g.id[i]) + " comes to wall \"" + wall.name +
                        "\" at t = " + std::to_string(state.time + dt) + " s, step " + std::to_string(state.steps) +
                        ", nearer than it moves in a step (it would go through a facet; must touch it with "
                        "its surface only). Try a larger normal_stiffness or a smaller step.",
                    sluice::Exit::numerical);
            });
        }
        feet.look(contacts, begin, end, radius);
    }
}

}  // namespace

template <int D>
void find_feet(Setup<D> const& setup, State<D>& state, double dt)
{
    for (std::size_t w = 0; w < setup.walls.size(); ++w)
        if (auto const* mesh = std::get_if<Mesh<D>>(&setup.walls[w].shape))
            find_feet_on(*mesh, setup.walls[w], state, state.walls[w], dt);
}

template void find_feet<2>(Setup<2> const&, State<2>&, double);
template void find_feet<3>(Setup<3> const&, State<3>&, double);

}  // namespace dem
