#pragma once

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

#include "participants/mpm/axial.hpp"
#include "participants/mpm/grid.hpp"
#include "participants/mpm/node_box.hpp"

//! Points as parallelograms, in space parallelepipeds, that deform with the matter (CPDI): the square or cube of the
//! start, by F. Hat functions N at the corners c, interpolated between them, replace those inside; means over the
//! domain are then sums over the corners. With the half edges as columns of R and s = (+-1, ...) of a corner:
//!
//!     place of c = x + R s,   weight = <N> = 2^-D sum N(c),   slope = <grad N> = 2^-D R^-T sum s N(c)
//!     rings, by volume: <r N>/r = 2^-D sum (1 + R_r s/(3 r)) N(c),   <r dN/d(s_k)>/r: its s_k without R_rk s_k/(3 r),
//!                       hoop = <N>/r                                          (R_r the row of the radius)
//!
//! Sources: Sadeghirad, Brannon and Burghardt, Int. J. Numer. Meth. Eng. 86 (2011) 1435; the bound on edges is that of
//! Homel, Brannon and Guilkey, Int. J. Numer. Meth. Eng. 107 (2016) 31, on each edge instead of each diagonal.
namespace mpm {

//! Least eigenvalue of the cosines between the edges of a domain: in the plane 26 degrees apart, a shear of 2.
inline constexpr double flattest = 0.1;

//! Keeps edges from lying too flat to each other: of their cosines C, C + share (I - C) is left, by the least change of
//! directions (Loewdin's). `edges`: of length 1.
template <int D>
void set_apart(Mat<D>& edges)
{
    Mat<D> const cosines = edges.transpose() * edges;
    double const most_beside = (cosines.cwiseAbs().rowwise().sum().array() - 1).maxCoeff();
    if (1 - most_beside > flattest) return;  // Gershgorin: no eigenvalue below
    Eigen::SelfAdjointEigenSolver<Mat<D>> const own(cosines);
    auto const& value = own.eigenvalues().array();
    if (value[0] >= flattest) return;
    if (value[0] < 1e-10) {  // parallel to rounding: no direction is left to keep
        edges.setIdentity();
        return;
    }
    double const share = (flattest - value[0]) / (1 - value[0]);
    Vec<D> const scale = (((1 - share) * value + share) / value).sqrt();
    edges = (edges * own.eigenvectors() * scale.asDiagonal() * own.eigenvectors().transpose()).eval();
}

//! Half the edges of a point's domain, as columns [cells]; at most a cell each: what is drawn out further parts. In a
//! flow that shears on and on F becomes a sliver, whose gradients have no bound; then its edges stay apart.
template <int D>
Mat<D> half_edges(Setup<D> const& setup, Point<D> const& point, Vec<D> const& place)
{
    Mat<D> R = setup.half_width * point.matter.gradient.template topLeftCorner<D, D>();
    Vec<D> const length = R.colwise().norm();
    R = (R * length.cwiseInverse().asDiagonal()).eval();
    set_apart<D>(R);
    R = (R * length.cwiseMin(1.0).asDiagonal()).eval();
    if (setup.symmetry == Symmetry::axial) {  // not beyond the axis
        double const extent = R.row(0).cwiseAbs().sum(), radius = place[0] / setup.cell;
        if (extent > radius) R.row(0) *= radius / extent;
    }
    return R;
}

template <int D>
class Parallelepiped
{
 public:
    static constexpr int corners = 1 << D;

    //! `half_edges` and `place` (from node 0) in cells, `radius` in cells, of rings; 0: none.
    Parallelepiped(Mat<D> const& half_edges, Vec<D> const& place, double cell, double radius)
        : edges_(half_edges), place_(place), cell_(cell), radius_(radius)
    {
        lay_out();
        Mat<D> const back = half_edges.inverse().transpose() / (corners * cell);
        for (int c = 0; c < corners; ++c) {
            Vec<D> const s = signs(c);
            Vec<D> lean = Vec<D>::Zero();  // R_rk s_k / (3 r)
            if (radius > 0) lean = half_edges.row(0).transpose().cwiseProduct(s) / (3 * radius);
            double const share = (1 + lean.sum()) / corners;
            Vec<D> const gradient = back * s.cwiseProduct(Vec<D>::Constant(1 + lean.sum()) - lean);
            each_node_of(corner(c), [&](std::array<int, D> const& node, double hat) {
                Entry& entry = entries_[box_.at(node)];
                entry.weight += share * hat;
                entry.mean += hat / corners;
                entry.gradient += hat * gradient;
            });
        }
    }

    //! each(node, weight, gradient of the weight)
    template <class Nodes, class Each>
    void each(Nodes& grid, Each&& each) const
    {
        for (std::size_t e = 0; e < count_; ++e)
            if (entries_[e].mean != 0) each(grid.reach(box_.index(e)), entries_[e].weight, entries_[e].gradient);
    }
    //! each(node, hoop), of rings
    template <class Nodes, class Each>
    void each_hoop(Nodes& grid, Each&& each) const
    {
        for (std::size_t e = 0; e < count_; ++e)
            if (entries_[e].mean != 0) each(grid.reach(box_.index(e)), entries_[e].mean / (radius_ * cell_));
    }
    //! each(node, weight), of the face across an edge at one of its ends; by the mean over it, of rings by area.
    template <class Nodes, class Each>
    void each_of_face(Nodes& grid, int edge, int side, Each&& each) const
    {
        Vec<D> const middle = place_ + side * edges_.col(edge);
        for (int c = 0; c < corners; ++c) {
            if (signs(c)[edge] != side) continue;
            double share = 2.0 / corners;
            if (radius_ > 0) share *= 1 + (corner(c) - middle)[0] / (3 * (radius_ + side * edges_(0, edge)));
            each_node_of(corner(c), [&](std::array<int, D> const& node, double hat) {
                if (hat > 0) each(grid.reach(node), share * hat);
            });
        }
    }
    //! Sum of weight x node, from the place [cells]: of rings the middle of the mass lies beyond that of the area.
    Vec<D> lean() const
    {
        return radius_ > 0 ? Vec<D>(edges_ * edges_.row(0).transpose() / (3 * radius_)) : Vec<D>(Vec<D>::Zero());
    }

 private:
    struct Entry
    {
        double weight, mean;  //!< of rings by volume, by area [-]
        Vec<D> gradient;      //!< [1/m]
    };
    static constexpr std::size_t most = D == 2 ? 7 * 7 : 9 * 9 * 9;  //!< edges within a cell each

    static Vec<D> signs(int c)
    {
        Vec<D> s;
        for (int k = 0; k < D; ++k) s[k] = (c >> k) % 2 == 0 ? -1 : 1;
        return s;
    }
    Vec<D> corner(int c) const { return place_ + edges_ * signs(c); }

    //! The box of nodes around all corners.
    void lay_out()
    {
        Vec<D> const extent = edges_.cwiseAbs().rowwise().sum();
        for (int k = 0; k < D; ++k) {
            auto const a = static_cast<std::size_t>(k);
            // a corner is summed otherwise than its bound: rounding
            box_.first[a] = static_cast<int>(std::floor(place_[k] - extent[k] - slack));
            box_.count[a] = static_cast<int>(std::floor(place_[k] + extent[k] + slack)) + 2 - box_.first[a];
        }
        count_ = box_.nodes();
        std::fill_n(entries_.begin(), count_, Entry{0, 0, Vec<D>::Zero()});
    }
    //! each(node, hat function at the place)
    template <class Each>
    static void each_node_of(Vec<D> const& place, Each&& each)
    {
        std::array<int, D> low;
        for (std::size_t k = 0; k < D; ++k) low[k] = static_cast<int>(std::floor(place[static_cast<int>(k)]));
        for (int n = 0; n < corners; ++n) {
            std::array<int, D> node = low;
            double hat = 1;
            for (std::size_t k = 0; k < D; ++k) {
                int const up = (n >> k) % 2;
                node[k] += up;
                double const beyond = place[static_cast<int>(k)] - low[k];
                hat *= up ? beyond : 1 - beyond;
            }
            each(node, hat);
        }
    }

    static constexpr double slack = 1e-9;  //!< [cells]

    Mat<D> edges_;
    Vec<D> place_;
    double cell_, radius_;
    NodeBox<D> box_;
    std::size_t count_;
    std::array<Entry, most> entries_;  //!< of which `count_` are set
};

}  // namespace mpm
