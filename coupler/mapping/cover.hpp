#pragma once

#include "coupler/mapping/neighbours.hpp"

namespace sluice {

template <int D>
struct Box
{
    Place<D> low, high;

    static Box around(Places<D> const& places)
    {
        Box box{places.at(0), places.at(0)};
        for (Place<D> const& x : places) box = {box.low.cwiseMin(x), box.high.cwiseMax(x)};
        return box;
    }
    Place<D> centre() const { return 0.5 * low + 0.5 * high; }
    double half_diagonal() const { return 0.5 * (high - low).norm(); }
    Place<D> nearest(Place<D> const& x) const { return x.cwiseMax(low).cwiseMin(high); }
};

template <int D>
struct Ball
{
    Place<D> centre;
    double radius;  //!< m
};

//! Balls that cover the box of all sources: the box is halved across its longest side until the ball around a piece has
//! no more than `most` sources. Pieces without a target near are left out.
template <int D>
class Cover
{
 public:
    Cover(Neighbours<D> const& sources, Neighbours<D> const& targets, std::size_t most, double overlap)
        : sources_(sources), targets_(targets), most_(most), overlap_(overlap)
    {}

    std::vector<Ball<D>> balls(Box<D> const& all)
    {
        smallest_ = 1e-12 * all.half_diagonal();
        divide(all);
        return std::move(balls_);
    }

 private:
    void divide(Box<D> const& box)
    {
        Place<D> const centre = box.centre();
        double const half = box.half_diagonal();
        double const radius = half > 0 ? (1 + overlap_) * half : 1.0;  // one place only: any ball will do
        targets_.within(centre, half + radius, found_);                // no ball of a part of this box goes further
        if (found_.empty()) return;
        sources_.within(centre, radius, found_);
        if (found_.size() <= most_ || half <= smallest_) {
            balls_.push_back({centre, radius});
            return;
        }
        Eigen::Index axis = 0;
        (box.high - box.low).maxCoeff(&axis);
        Box<D> low = box, high = box;
        low.high[axis] = high.low[axis] = centre[axis];
        divide(low);
        divide(high);
    }

    Neighbours<D> const& sources_;
    Neighbours<D> const& targets_;
    std::size_t most_;
    double overlap_;
    double smallest_ = 0;
    std::vector<Neighbour> found_;
    std::vector<Ball<D>> balls_;
};

}  // namespace sluice
