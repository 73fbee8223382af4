#include "participants/dem/slabs.hpp"

#include <cmath>
#include <cstdint>
#include <limits>

namespace dem {
namespace {

constexpr int most_rounds = 60;  // halvings: then a bound is as exact as its number

template <int D>
struct Box
{
    Vec<D> low, high;
};

//! Of all centres; without any: low > high.
template <int D>
Box<D> box_of(ranks::Peers& peers, std::span<Vec<D> const> centres)
{
    double const most = std::numeric_limits<double>::infinity();
    Box<D> box;
    auto const widen = [&](Vec<D> const& low, Vec<D> const& high) {
        for (int k = 0; k < D; ++k) {
            component<D>(box.low, k) = std::min(component(box.low, k), component(low, k));
            component<D>(box.high, k) = std::max(component(box.high, k), component(high, k));
        }
    };
    for (int k = 0; k < D; ++k) component<D>(box.low, k) = most, component<D>(box.high, k) = -most;
    for (Vec<D> const& centre : centres) widen(centre, centre);
    for (Box<D> const& other : ranks::everyone(peers, box)) widen(other.low, other.high);
    return box;
}

//! One bound on its way to where so many centres lie below it.
struct Search
{
    double low, high, best;
    std::int64_t wanted, missed;

    double middle() const { return low + 0.5 * (high - low); }
    void learn(std::int64_t below)
    {
        double const tried = middle();
        if (std::abs(below - wanted) < missed) {
            missed = std::abs(below - wanted);
            best = tried;
        }
        (below < wanted ? low : high) = tried;
    }
};

}  // namespace

template <int D>
Slabs<D> even_slabs(ranks::Peers& peers, std::span<Vec<D> const> centres)
{
    auto const slabs = static_cast<std::int64_t>(peers.count());
    Box<D> const box = box_of(peers, centres);
    std::int64_t const all = ranks::sums(peers, {static_cast<std::int64_t>(centres.size())})[0];
    Slabs<D> chosen;
    chosen.bounds.assign(static_cast<std::size_t>(slabs - 1), 0.0);
    if (all == 0) return chosen;
    for (int k = 1; k < D; ++k)
        if (component(box.high - box.low, k) > component(box.high - box.low, chosen.axis)) chosen.axis = k;
    std::vector<double> at;
    for (Vec<D> const& centre : centres) at.push_back(component(centre, chosen.axis));
    std::sort(at.begin(), at.end());
    double const low = component(box.low, chosen.axis), high = component(box.high, chosen.axis);
    std::vector<Search> searches;
    for (std::int64_t k = 1; k < slabs; ++k) searches.push_back({low, high, low, all * k / slabs, all});
    std::int64_t const tolerance = all / (200 * slabs);
    for (int round = 0; round < most_rounds; ++round) {
        std::vector<std::int64_t> below;
        for (Search const& s : searches)
            below.push_back(std::lower_bound(at.begin(), at.end(), s.middle()) - at.begin());
        below = ranks::sums(peers, below);
        std::int64_t worst = 0;
        for (std::size_t k = 0; k < searches.size(); ++k) {
            searches[k].learn(below[k]);
            worst = std::max(worst, searches[k].missed);
        }
        if (worst <= tolerance) break;
    }
    for (std::size_t k = 0; k < searches.size(); ++k) chosen.bounds[k] = searches[k].best;
    std::sort(chosen.bounds.begin(), chosen.bounds.end());
    return chosen;
}

template Slabs<2> even_slabs<2>(ranks::Peers&, std::span<Vec<2> const>);
template Slabs<3> even_slabs<3>(ranks::Peers&, std::span<Vec<3> const>);

}  // namespace dem
