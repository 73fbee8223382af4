#include <cmath>

#include "coupler/mapping/linear_fit.hpp"
#include "coupler/mapping/neighbours.hpp"
#include "coupler/mapping/wendland.hpp"

namespace sluice {

namespace {

constexpr std::size_t most_neighbours = 256;  //!< looked at where few lie on a line or on one side only

//! Builds one row after the other; keeps its memory in between.
template <int D>
class LinearRows
{
 public:
    explicit LinearRows(Places<D> const& sources)
        : sources_(sources), near_(sources), rank_(LinearFit<D>(sources, std::vector<double>(sources.size(), 1)).rank())
    {}

    //! Adds the row of a target; true if it is out of reach.
    bool add(MappingRows& rows, Place<D> const& at)
    {
        std::size_t const most = std::min(most_neighbours, sources_.size());
        for (std::size_t count = D == 2 ? 12 : 20;; count *= 2) {
            choose(at, std::min(count, most));
            LinearFit<D> const fit(place_, weight_);
            auto const [local, clamped] = fit.local(at);
            if ((clamped || fit.rank() < rank_) && count < most) continue;
            row_.assign(weight_.size(), 0.0);
            fit.complete(local, row_.data());
            rows.source.insert(rows.source.end(), source_.begin(), source_.end());
            rows.weight.insert(rows.weight.end(), row_.begin(), row_.end());
            rows.end_row();
            return clamped;
        }
    }

 private:
    //! The nearest has weight 1, the last of `count` has 0: which of several equally far ones is last does not matter.
    void choose(Place<D> const& at, std::size_t count)
    {
        near_.nearest(at, count, found_);
        double const first = std::sqrt(found_.front().square);
        double const last = (count < sources_.size() ? 1 : 1.5) * (std::sqrt(found_.back().square) - first);
        source_.clear();
        place_.clear();
        weight_.clear();
        for (Neighbour const& n : found_) {
            double const w = last > 0 ? wendland_c2((std::sqrt(n.square) - first) / last) : 1;
            if (w == 0) continue;
            source_.push_back(n.index);
            place_.push_back(sources_[n.index]);
            weight_.push_back(w);
        }
    }

    Places<D> const& sources_;
    Neighbours<D> near_;
    int rank_;
    std::vector<Neighbour> found_;
    std::vector<std::uint32_t> source_;
    Places<D> place_;
    std::vector<double> weight_, row_;
};

template <int D>
Mapping linear(Places<D> const& sources, Places<D> const& targets)
{
    MappingRows rows;
    if (targets.empty()) return Mapping(rows, sources.size());
    LinearRows<D> build(sources);
    std::size_t out_of_reach = 0;
    for (Place<D> const& at : targets) out_of_reach += build.add(rows, at);
    return Mapping(std::move(rows), sources.size(), out_of_reach);
}

}  // namespace

Mapping map_linear(Points sources, Points targets)
{
    return build_mapping("linear", sources, targets, [](auto const& from, auto const& to) { return linear(from, to); });
}

}  // namespace sluice
