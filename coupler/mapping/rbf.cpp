#include <Eigen/Cholesky>
#include <cmath>
#include <numeric>

#include "coupler/mapping/cover.hpp"
#include "coupler/mapping/linear_fit.hpp"
#include "coupler/mapping/wendland.hpp"

namespace sluice {

namespace {

//! Which sources share a place: those of group g are order[begin[g]] to order[begin[g + 1]].
struct Groups
{
    std::vector<std::uint32_t> order;
    std::vector<std::size_t> begin;
    std::size_t size(std::uint32_t g) const { return begin[g + 1] - begin[g]; }
};

template <int D>
Groups group(Places<D> const& sources)
{
    Groups groups;
    groups.order.resize(sources.size());
    std::iota(groups.order.begin(), groups.order.end(), 0U);
    std::ranges::sort(groups.order, [&](std::uint32_t a, std::uint32_t b) {
        for (int k = 0; k < D; ++k)
            if (sources[a][k] != sources[b][k]) return sources[a][k] < sources[b][k];
        return a < b;
    });
    for (std::size_t i = 0; i < sources.size(); ++i)
        if (i == 0 || sources[groups.order[i]] != sources[groups.order[i - 1]]) groups.begin.push_back(i);
    groups.begin.push_back(sources.size());
    return groups;
}

//! One ball of the partition of unity.
template <int D>
struct Patch
{
    Ball<D> ball;
    double support = 0;                  //!< radius of the basis function [m]
    std::vector<std::uint32_t> sources;  //!< groups
    std::vector<std::uint32_t> targets;
    std::vector<double> blend;  //!< of each target, before division by the sum over the balls
};

//! The Gram matrix, factorised. Two sources much closer than the others make it nearly singular: their values are then
//! smoothed by 1e-10 of the diagonal.
Eigen::LLT<Eigen::MatrixXd> factorise(Eigen::MatrixXd& gram)
{
    Eigen::LLT<Eigen::MatrixXd> factor(gram);
    double const pivot = factor.matrixLLT().diagonal().minCoeff();
    if (factor.info() != Eigen::Success || pivot * pivot < 1e-10) {
        gram.diagonal().array() += 1e-10;
        factor.compute(gram);
    }
    require(factor.info() == Eigen::Success, [] {
        return Error("mapping rbf: sources lie too close together for the basis function. Use a smaller support.",
                     Exit::numerical);
    });
    return factor;
}

//! Where a target lies far from sources that are close together, the weights of the radial functions grow without
//! bound, alternating in sign: noise and rounding would grow with them. Their magnitudes may sum to 30; among evenly
//! scattered sources they do not come near.
void limit(double* row, std::size_t n)
{
    double size = 0;
    for (std::size_t i = 0; i < n; ++i) size += std::abs(row[i]);
    if (size <= 30) return;
    for (std::size_t i = 0; i < n; ++i) row[i] *= 30 / size;
}

template <int D>
class Rbf
{
 public:
    Rbf(Places<D> const& sources, Places<D> const& targets, RbfOptions const& options)
        : targets_(targets), options_(options), groups_(group(sources)), count_(sources.size())
    {
        for (std::size_t g = 0; g + 1 < groups_.begin.size(); ++g)
            places_.push_back(sources[groups_.order[groups_.begin[g]]]);
        if (options_.patch_points == 0) options_.patch_points = D == 2 ? 50 : 80;
    }

    Mapping build()
    {
        find_patches();
        allocate();
        for (Patch<D> const& patch : patches_) add_rows(patch);
        return Mapping(std::move(rows_), count_, static_cast<std::size_t>(std::ranges::count(clamped_, char{1})));
    }

 private:
    void find_patches()
    {
        Box<D> const box = Box<D>::around(places_);
        Places<D> inside;  // a target outside takes the balls that cover the nearest place inside
        for (Place<D> const& t : targets_) inside.push_back(box.nearest(t));
        Neighbours<D> const near_sources(places_), near_targets(inside);
        auto const most = static_cast<std::size_t>(options_.patch_points);
        blend_.assign(targets_.size(), 0.0);
        std::vector<Neighbour> found;
        for (Ball<D> const& ball : Cover<D>(near_sources, near_targets, most, options_.overlap).balls(box)) {
            near_targets.within(ball.centre, ball.radius, found);
            if (found.empty()) continue;
            Patch<D> patch{ball, 0, {}, {}, {}};
            for (Neighbour const& n : found) {
                patch.targets.push_back(n.index);
                patch.blend.push_back(wendland_c2(std::sqrt(n.square) / ball.radius));
                blend_[n.index] += patch.blend.back();
            }
            take_sources(near_sources, patch, most);
            patches_.push_back(std::move(patch));
        }
    }

    //! Those in the ball; the nearest ones if they are too few (a gap) or too many (nearly coincident).
    void take_sources(Neighbours<D> const& near, Patch<D>& patch, std::size_t most) const
    {
        std::vector<Neighbour> found;
        near.within(patch.ball.centre, patch.ball.radius, found);
        std::size_t const fewest = std::max<std::size_t>(most / 3, 1);
        if (found.size() < fewest || found.size() > most)
            near.nearest(patch.ball.centre, found.size() > most ? most : fewest, found);
        double furthest = patch.ball.radius;
        for (Neighbour const& n : found) {
            patch.sources.push_back(n.index);
            furthest = std::max(furthest, std::sqrt(n.square));
        }
        patch.support = options_.support * furthest;
    }

    void allocate()
    {
        std::vector<std::size_t> entries(targets_.size(), 0);
        for (Patch<D> const& patch : patches_) {
            std::size_t n = 0;
            for (std::uint32_t const g : patch.sources) n += groups_.size(g);
            for (std::uint32_t const t : patch.targets) entries[t] += n;
        }
        for (std::size_t const n : entries) rows_.begin.push_back(rows_.begin.back() + n);
        cursor_.assign(rows_.begin.begin(), rows_.begin.end() - 1);
        rows_.source.resize(rows_.begin.back());
        rows_.weight.resize(rows_.begin.back());
        clamped_.assign(targets_.size(), 0);
    }

    void add_rows(Patch<D> const& patch)
    {
        Places<D> place;
        for (std::uint32_t const g : patch.sources) place.push_back(places_[g]);
        std::vector<double> const ones(place.size(), 1.0);
        LinearFit<D> const fit(place, ones);
        auto const basis = [&](Place<D> const& a, Place<D> const& b) {
            return wendland_c2((a - b).norm() / patch.support);
        };
        auto const n = static_cast<Eigen::Index>(place.size());
        Eigen::MatrixXd gram(n, n), row(n, static_cast<Eigen::Index>(patch.targets.size()));
        for (std::size_t j = 0; j < place.size(); ++j)
            for (std::size_t i = 0; i < place.size(); ++i)
                gram(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = basis(place[i], place[j]);
        for (std::size_t k = 0; k < patch.targets.size(); ++k)
            for (std::size_t i = 0; i < place.size(); ++i)
                row(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) =
                    basis(place[i], targets_[patch.targets[k]]);
        factorise(gram).solveInPlace(row);
        for (std::size_t k = 0; k < patch.targets.size(); ++k) {
            std::uint32_t const t = patch.targets[k];
            auto const [local, clamped] = fit.local(targets_[t]);
            clamped_[t] = static_cast<char>(clamped_[t] | static_cast<char>(clamped));
            double* const weight = &row(0, static_cast<Eigen::Index>(k));
            limit(weight, place.size());
            fit.complete(local, weight);
            write(t, patch.sources, weight, patch.blend[k] / blend_[t]);
        }
    }

    //! Appends share * weight to the row of target t; a group's weight is shared equally.
    void write(std::uint32_t t, std::vector<std::uint32_t> const& sources, double const* weight, double share)
    {
        for (std::size_t i = 0; i < sources.size(); ++i) {
            std::uint32_t const g = sources[i];
            double const each = share * weight[i] / static_cast<double>(groups_.size(g));
            for (std::size_t m = groups_.begin[g]; m < groups_.begin[g + 1]; ++m) {
                rows_.source[cursor_[t]] = groups_.order[m];
                rows_.weight[cursor_[t]++] = each;
            }
        }
    }

    Places<D> const& targets_;
    RbfOptions options_;
    Groups groups_;
    std::size_t count_;  //!< sources
    Places<D> places_;   //!< of the groups
    std::vector<Patch<D>> patches_;
    std::vector<double> blend_;  //!< sum over the balls, of each target
    MappingRows rows_;
    std::vector<std::size_t> cursor_;  //!< where each target's row goes on
    std::vector<char> clamped_;
};

}  // namespace

Mapping map_rbf(Points sources, Points targets, RbfOptions options)
{
    require(options.patch_points >= 0 && options.overlap >= 0.01 && options.overlap <= 2 && options.support >= 0.5 &&
                options.support <= 100,
            [] {
                return Error(
                    "mapping rbf: an option is out of range (patch_points >= 0, overlap 0.01 to 2, support "
                    "0.5 to 100).");
            });
    return build_mapping("rbf", sources, targets, [&](auto const& from, auto const& to) {
        if (to.empty()) return Mapping({}, from.size());
        return Rbf(from, to, options).build();
    });
}

}  // namespace sluice
