#include "participants/mpm/transfer.hpp"

#include <Eigen/Eigenvalues>
#include <type_traits>

#include "participants/mpm/cell.hpp"
#include "participants/mpm/parallelepiped.hpp"
#include "participants/mpm/stencil.hpp"

namespace mpm {
namespace {

//! Half the width of a point along each axis [cells]: that at the start, times the diagonal of the stretch U,
//! F = (rotation) U, if it follows. Source: Charlton, Coombs and Augarde, Comput. Struct. 190 (2017) 108.
template <int D>
Vec<D> half_width_of(Setup<D> const& setup, Point<D> const& point)
{
    Vec<D> half = Vec<D>::Constant(setup.half_width);
    if (setup.width == Width::stretch) {
        Mat<D> const F = point.matter.gradient.template topLeftCorner<D, D>();
        Mat<D> const U = Eigen::SelfAdjointEigenSolver<Mat<D>>(F.transpose() * F).operatorSqrt();
        half = (setup.half_width * U.diagonal()).cwiseMin(0.5);
    }
    return half;
}

//! Half the width of a ring, that may reach up to the axis [cells].
template <int D>
double half_ring(Setup<D> const& setup, Vec<D> const& half_width, Vec<D> const& place)
{
    return std::min(half_width[0], place[0] / setup.cell);
}

template <int D, class Basis>
using StencilOf = std::conditional_t<std::is_same_v<Basis, Cpdi>, Parallelepiped<D>, Stencil<D, Basis>>;

template <int D, class Basis>
StencilOf<D, Basis> stencil_at(Setup<D> const& setup, Point<D> const& point,
                               Vec<D> const& place) requires std::is_same_v<Basis, Cpdi>
{
    double const radius = setup.symmetry == Symmetry::axial ? place[0] / setup.cell : 0;
    return {half_edges(setup, point, place), (place - setup.origin) / setup.cell, setup.cell, radius};
}
template <int D, class Basis>
StencilOf<D, Basis> stencil_at(Setup<D> const& setup, Point<D> const& point, Vec<D> const& place)
{
    Vec<D> half_width = half_width_of(setup, point);
    Vec<D> const in_cells = (place - setup.origin) / setup.cell;
    if (setup.symmetry == Symmetry::plane) return {half_width, in_cells, setup.cell};
    half_width[0] = half_ring(setup, half_width, place);
    Stencil<D, Basis> at(half_width, in_cells, setup.cell);
    at.turn_around(place[0] / setup.cell, half_width[0], in_cells[0], setup.cell);
    return at;
}

//! Sum of weight x node: the middle of a ring's mass lies beyond that of its area.
template <int D>
Vec<D> centre_of(Setup<D> const& setup, Point<D> const&, Vec<D> const& place, Parallelepiped<D> const& at)
{
    return place + setup.cell * at.lean();
}
template <int D, class Basis>
Vec<D> centre_of(Setup<D> const& setup, Point<D> const& point, Vec<D> const& place, Stencil<D, Basis> const&)
{
    Vec<D> centre = place;
    if (setup.symmetry == Symmetry::axial) {
        double const half = setup.cell * half_ring(setup, half_width_of(setup, point), place);
        centre[0] += half * half / (3 * place[0]);
    }
    return centre;
}

//! A traction acts where the face is: on the hat function there across its axis, on the point's own along it. A uniform
//! stress in points that fill space is then in balance with its tractions, to rounding, wherever they stand. A
//! parallelepiped has a face.
template <int D, class Basis>
void add_traction(Setup<D> const& setup, Traction<D> const& traction, Point<D> const& point,
                  Grid<D>& grid) requires std::is_same_v<Basis, Cpdi>
{
    auto const at = stencil_at<D, Basis>(setup, point, point.place);
    double const half = setup.half_width * setup.cell;
    double area = point.volume / (2 * half);
    if (setup.symmetry == Symmetry::axial && traction.axis == 0)  // of the ring of the start
        area *= 1 + traction.side * half * point.matter.gradient(2, 2) / point.place[0];
    at.each_of_face(grid, traction.axis, traction.side,
                    [&](Node<D>& node, double weight) { node.outer += weight * area * traction.stress; });
}
template <int D, class Basis>
void add_traction(Setup<D> const& setup, Traction<D> const& traction, Point<D> const& point, Grid<D>& grid)
{
    Vec<D> const centre = (point.place - setup.origin) / setup.cell;
    Vec<D> const half_width = half_width_of(setup, point);
    auto at = stencil_at<D, Basis>(setup, point, point.place);
    auto const axis = static_cast<std::size_t>(traction.axis);
    double const face = centre[traction.axis] + traction.side * half_width[traction.axis];
    Linear const hat(0);
    for (std::size_t j = 0; j < Basis::width; ++j)
        at.weight[axis][j] = hat.value(face - (at.first[axis] + static_cast<int>(j)));
    double area = point.volume / (2 * setup.half_width * setup.cell);
    if (axis == 0) {
        Vec<D> on_face = point.place;
        on_face[0] = setup.origin[0] + setup.cell * face;
        area *= girth(setup.symmetry, on_face) / girth(setup.symmetry, point.place);
    }
    at.each(grid, [&](Node<D>& node, double weight, Vec<D> const&) { node.outer += weight * area * traction.stress; });
}

//! What a point that was at `place` with a velocity and its gradient brings to its nodes. Since sum w (x_i - x) = 0,
//! the gradient takes part without adding momentum; with it a linear field of velocities arrives on the grid as it is.
template <int D, class Basis>
void bring_momentum(Setup<D> const& setup, Point<D> const& point, Vec<D> const& place, StencilOf<D, Basis> const& at,
                    Grid<D>& grid, Vec<D> Node<D>::*momentum)
{
    Vec<D> const centre = centre_of(setup, point, place, at);
    at.each(grid, [&](Node<D>& node, double weight, Vec<D> const&) {
        Vec<D> velocity = point.velocity;
        if (setup.affine) velocity += point.slope * setup.arm(centre, corner_of<D>(setup, node.index));
        node.*momentum += weight * point.mass * velocity;
    });
}

template <int D, class Basis>
void to_grid(Setup<D> const& setup, State<D> const& state, std::span<Vec<D> const> loads,
             std::span<double const> shifts, Grid<D>& grid)
{
    for (std::size_t p = 0; p < state.points.size(); ++p) {
        Point<D> const& point = state.points[p];
        Mat<D> stress = point.matter.stress.template topLeftCorner<D, D>();
        if (!shifts.empty()) stress += shifts[p] * Mat<D>::Identity();
        Mat<D> const pull = point.volume_now() * stress;
        Vec<D> const load = loads.empty() ? Vec<D>::Zero() : loads[p];
        auto const at = stencil_at<D, Basis>(setup, point, point.place);
        at.each(grid, [&](Node<D>& node, double weight, Vec<D> const& gradient) {
            node.mass += weight * point.mass;
            node.inner -= pull * gradient;
            node.outer += weight * load;
        });
        if (setup.symmetry == Symmetry::axial) {
            double const around = point.volume_now() * (point.matter.stress(2, 2) + (shifts.empty() ? 0 : shifts[p]));
            at.each_hoop(grid, [&](Node<D>& node, double hoop) { node.inner[0] -= around * hoop; });
        }
        bring_momentum<D, Basis>(setup, point, point.place, at, grid, &Node<D>::momentum);
    }
    for (auto const& traction : setup.tractions)
        add_traction<D, Basis>(setup, traction, state.points[traction.point], grid);
}

template <int D, class Basis>
void to_points(Setup<D> const& setup, Field<D> const& field, State<D>& state, Grid<D>& grid, double dt)
{
    for (Point<D>& point : state.points) {
        Vec<D> carried = Vec<D>::Zero(), change = Vec<D>::Zero();
        point.slope.setZero();
        auto const at = stencil_at<D, Basis>(setup, point, point.place);
        at.each(grid, [&](Node<D>& node, double weight, Vec<D> const& gradient) {
            carried += weight * node.velocity;
            change += weight * (node.velocity - node.before);
            if (setup.affine) point.slope += node.velocity * gradient.transpose();
        });
        if (setup.frame) point.velocity = field.turned(point.velocity);
        point.velocity = setup.flip * (point.velocity + change) + (1 - setup.flip) * carried;
        if (setup.symmetry == Symmetry::axial) {  // the radius by the stretch around the axis
            carried[0] = 0;
            at.each_hoop(grid,
                         [&](Node<D>& node, double hoop) { carried[0] += point.place[0] * hoop * node.velocity[0]; });
        }
        point.place += dt * carried;
    }
}

template <int D, class Basis>
void back_to_grid(Setup<D> const& setup, State<D> const& state, std::span<Vec<D> const> places, Grid<D>& grid)
{
    for (std::size_t p = 0; p < places.size(); ++p) {
        Point<D> const& point = state.points[p];
        bring_momentum<D, Basis>(setup, point, places[p], stencil_at<D, Basis>(setup, point, places[p]), grid,
                                 &Node<D>::strain_velocity);
    }
}

template <int D, class Basis>
void gradients(Setup<D> const& setup, State<D> const& state, std::span<Vec<D> const> places, Grid<D>& grid, double dt,
               std::vector<Mat3>& out)
{
    for (std::size_t p = 0; p < places.size(); ++p) {
        Mat<D> increment = Mat<D>::Identity();
        auto const at = stencil_at<D, Basis>(setup, state.points[p], places[p]);
        at.each(grid, [&](Node<D>& node, double, Vec<D> const& gradient) {
            increment += dt * node.strain_velocity * gradient.transpose();
        });
        out[p] = in_space(increment, 1);
        if (setup.symmetry == Symmetry::axial)
            at.each_hoop(grid,
                         [&](Node<D>& node, double hoop) { out[p](2, 2) += dt * hoop * node.strain_velocity[0]; });
    }
}

template <int D, class Basis>
constexpr Transfer<D> transfer{to_grid<D, Basis>, to_points<D, Basis>, back_to_grid<D, Basis>, gradients<D, Basis>};

}  // namespace

template <int D>
Transfer<D> const& transfer_of(BasisKind basis)
{
    static constexpr Transfer<D> of[] = {transfer<D, Gimp>, transfer<D, Linear>, transfer<D, Spline>,
                                         transfer<D, Cpdi>};
    return of[static_cast<std::size_t>(basis)];
}

template Transfer<2> const& transfer_of<2>(BasisKind);
template Transfer<3> const& transfer_of<3>(BasisKind);

}  // namespace mpm
