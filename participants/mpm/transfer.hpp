#pragma once

#include <span>

#include "participants/mpm/field.hpp"
#include "participants/mpm/grid.hpp"
#include "participants/mpm/state.hpp"

//! Loops between points and grid: one variant per dimension and basis, chosen once. Sums run over the points in their
//! order.
namespace mpm {

template <int D>
struct Transfer
{
    //! Mass, momentum and forces of the points on the nodes. One a point, or none: `loads` [N]; `shifts` of the mean
    //! stress that pulls, from its own [Pa].
    void (*to_grid)(Setup<D> const&, State<D> const&, std::span<Vec<D> const> loads, std::span<double const> shifts,
                    Grid<D>&);
    //! New velocities and places of the points.
    void (*to_points)(Setup<D> const&, Field<D> const&, State<D>&, Grid<D>&, double dt);
    //! Momentum of the points as they are now, at the weights of the `places` where they were; for MUSL.
    void (*back_to_grid)(Setup<D> const&, State<D> const&, std::span<Vec<D> const> places, Grid<D>&);
    //! The increment of the deformation gradient of each point, at the weights of the `places` where it was.
    void (*gradients)(Setup<D> const&, State<D> const&, std::span<Vec<D> const> places, Grid<D>&, double dt,
                      std::vector<Mat3>&);
};

template <int D>
Transfer<D> const& transfer_of(BasisKind basis);

}  // namespace mpm
