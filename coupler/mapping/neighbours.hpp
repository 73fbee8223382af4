#pragma once

#include <algorithm>
#include <limits>
#include <nanoflann.hpp>

#include "coupler/mapping/places.hpp"

namespace sluice {

struct Neighbour
{
    std::uint32_t index = 0;
    double square = std::numeric_limits<double>::infinity();  //!< of the distance [m2]
};

//! Who is near a place; a k-d tree over places that must outlive it.
template <int D>
class Neighbours
{
 public:
    explicit Neighbours(Places<D> const& places) : places_(places), tree_(D, *this) {}

    std::size_t size() const noexcept { return places_.size(); }

    //! At equal distance the one with smaller x, then y, then z, then index: no matter how the points are numbered.
    Neighbour nearest(Place<D> const& at) const
    {
        Nearest result{places_, {}};
        tree_.findNeighbors(result, at.data(), nanoflann::SearchParams());
        return result.best;
    }

    //! The `count` nearest, or all if there are fewer; nearest first.
    void nearest(Place<D> const& at, std::size_t count, std::vector<Neighbour>& found) const
    {
        count = std::min(count, size());
        index_.resize(count);
        square_.resize(count);
        tree_.knnSearch(at.data(), count, index_.data(), square_.data());
        found.resize(count);
        for (std::size_t k = 0; k < count; ++k) found[k] = {index_[k], square_[k]};
    }

    //! All that are nearer than `radius` [m].
    void within(Place<D> const& at, double radius, std::vector<Neighbour>& found) const
    {
        found.clear();
        if (size() == 0) return;
        Within result{radius * radius, found};
        tree_.findNeighbors(result, at.data(), nanoflann::SearchParams());
    }

    // what nanoflann asks of a data set
    std::size_t kdtree_get_point_count() const { return places_.size(); }
    double kdtree_get_pt(std::size_t i, std::size_t axis) const { return places_[i][static_cast<Eigen::Index>(axis)]; }
    template <class Box>
    bool kdtree_get_bbox(Box&) const
    {
        return false;
    }

 private:
    using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Neighbours>, Neighbours, D>;

    struct Nearest
    {
        Places<D> const& places;
        Neighbour best;

        bool addPoint(double square, std::uint32_t index)
        {
            if (square < best.square || (square == best.square && before(index))) best = {index, square};
            return true;
        }
        //! A little more than the best, so that equals are offered too, also from other branches.
        double worstDist() const { return best.square * (1 + 1e-9) + std::numeric_limits<double>::min(); }
        bool full() const { return true; }
        bool before(std::uint32_t index) const
        {
            for (int k = 0; k < D; ++k)
                if (places[index][k] != places[best.index][k]) return places[index][k] < places[best.index][k];
            return index < best.index;
        }
    };

    struct Within
    {
        double square;
        std::vector<Neighbour>& found;

        bool addPoint(double distance, std::uint32_t index)
        {
            if (distance < square) found.push_back({index, distance});
            return true;
        }
        double worstDist() const { return square; }
        bool full() const { return true; }
    };

    Places<D> const& places_;
    Tree tree_;
    mutable std::vector<std::uint32_t> index_;
    mutable std::vector<double> square_;
};

}  // namespace sluice
