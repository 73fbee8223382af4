#include "participants/mpm/parallelepiped.hpp"

#include <doctest/doctest.h>

#include <cmath>

#include "participants/mpm/setup.hpp"
#include "participants/mpm/stencil.hpp"
#include "tests/participants/mpm/scenes.hpp"
#include "tests/support/close_to.hpp"

namespace {

constexpr double rounding = 1e-14, cell = 0.5;

//! Sums over the nodes [cells].
template <int D>
struct Sums
{
    double weight = 0;
    mpm::Vec<D> place = mpm::Vec<D>::Zero();
    mpm::Mat<D> gradient = mpm::Mat<D>::Zero();
};

template <int D>
Sums<D> sums_of(mpm::Parallelepiped<D> const& at, mpm::Grid<D>& grid)
{
    Sums<D> sums;
    at.each(grid, [&](mpm::Node<D>& node, double weight, mpm::Vec<D> const& slope) {
        mpm::Vec<D> x;
        for (int k = 0; k < D; ++k) x[k] = node.index[static_cast<std::size_t>(k)];
        sums.weight += weight;
        sums.place += weight * x;
        sums.gradient += cell * x * slope.transpose();
    });
    return sums;
}

template <int D>
mpm::Grid<D> grid_of(int cells)
{
    std::array<int, D> all;
    all.fill(cells);
    return mpm::Grid<D>(all, {}, mpm::rings_of_nodes(mpm::BasisKind::cpdi, D));
}

//! Half edges that are neither along the axes nor at right angles, the longest a cell.
template <int D>
mpm::Mat<D> askew()
{
    mpm::Mat3 R;
    R << 0.9, 0.2, 0.1, -0.3, 0.4, -0.25, 0.2, -0.1, 0.6;
    return R.topLeftCorner<D, D>();
}

template <int D>
void check_linear_field()
{
    auto grid = grid_of<D>(6);
    mpm::Vec<D> place;
    for (int k = 0; k < D; ++k) place[k] = 2.3 + 0.7 * k;
    auto const sums = sums_of<D>({askew<D>(), place, cell, 0}, grid);
    CHECK(std::abs(sums.weight - 1) < rounding);
    CHECK((sums.place - place).norm() < 10 * rounding);
    CHECK((sums.gradient - mpm::Mat<D>::Identity()).norm() < 10 * rounding);
}

}  // namespace

TEST_CASE("parallelepiped: weights reproduce a linear field, plane and space")
{
    check_linear_field<2>();
    check_linear_field<3>();
}

TEST_CASE("parallelepiped: a square that lies in one cell has the weights of gimp")
{
    mpm::Vec<2> const place(1.4, 2.55);
    mpm::Grid<2> grid({4, 4}), other({4, 4});
    mpm::Parallelepiped<2> const corners(0.25 * mpm::Mat<2>::Identity(), place, cell, 0);
    mpm::Stencil<2, mpm::Gimp> const axes(mpm::Vec<2>::Constant(0.25), place, cell);
    corners.each(grid, [](auto& node, double weight, auto const& slope) { node.mass = weight, node.momentum = slope; });
    axes.each(other, [&](auto& node, double weight, auto const& slope) {
        CHECK(std::abs(grid.reach(node.index).mass - weight) < rounding);
        CHECK((grid.reach(node.index).momentum - slope).norm() < 10 * rounding);
    });
}

//! Means over the domain of what is interpolated between its corners, by sums over its parts.
TEST_CASE("parallelepiped: rings are means by volume, around the axis by area")
{
    double const radius = 2.2;
    mpm::Mat<2> const R = askew<2>();
    mpm::Vec<2> const place(radius, 3.1);
    auto grid = grid_of<2>(6), whole = grid_of<2>(6);
    mpm::Parallelepiped<2> const at(R, place, cell, radius);
    mpm::Linear const hat(0);
    auto const mean = [&](mpm::Node<2> const& node, auto&& of) {
        double sum = 0;
        int const parts = 400;
        for (int i = 0; i < parts * parts; ++i) {
            mpm::Vec<2> const u(2 * (i % parts + 0.5) / parts - 1, 2 * (i / parts + 0.5) / parts - 1);
            double value = 0;
            mpm::Vec<2> slope = mpm::Vec<2>::Zero();
            for (int c = 0; c < 4; ++c) {
                mpm::Vec<2> const s(c % 2 == 0 ? -1 : 1, c / 2 == 0 ? -1 : 1), corner = place + R * s;
                double const N = hat.value(corner[0] - node.index[0]) * hat.value(corner[1] - node.index[1]) / 4;
                value += N * (1 + s[0] * u[0]) * (1 + s[1] * u[1]);
                slope += N * mpm::Vec<2>(s[0] * (1 + s[1] * u[1]), s[1] * (1 + s[0] * u[0]));
            }
            sum += of((place + R * u)[0] / radius, value, mpm::Vec<2>(R.inverse().transpose() * slope / cell));
        }
        return sum / (parts * parts);
    };
    double const parts_error = 1e-4;
    at.each(grid, [&](mpm::Node<2>& node, double weight, mpm::Vec<2> const& slope) {
        CHECK(std::abs(weight - mean(node, [](double r, double N, auto const&) { return r * N; })) < parts_error);
        for (int k : {0, 1})
            CHECK(std::abs(slope[k] - mean(node, [k](double r, double, auto const& s) { return r * s[k]; })) <
                  parts_error);
    });
    at.each_hoop(grid, [&](mpm::Node<2>& node, double hoop) {
        double const exact = mean(node, [](double, double N, auto const&) { return N; }) / (radius * cell);
        CHECK(std::abs(hoop - exact) < parts_error);
    });
    CHECK((sums_of<2>(at, whole).place - place - at.lean()).norm() < 10 * rounding);
}

TEST_CASE("parallelepiped: faces have all their weight at their middle")
{
    auto grid = grid_of<2>(6);
    mpm::Vec<2> const place(2.4, 3.1);
    mpm::Parallelepiped<2> const at(askew<2>(), place, cell, 0);
    for (int edge : {0, 1})
        for (int side : {-1, 1}) {
            mpm::Vec<2> sum = mpm::Vec<2>::Zero();
            double whole = 0;
            at.each_of_face(grid, edge, side, [&](mpm::Node<2>& node, double weight) {
                whole += weight;
                sum += weight * mpm::Vec<2>(node.index[0], node.index[1]);
            });
            CHECK(std::abs(whole - 1) < rounding);
            CHECK((sum - place - side * askew<2>().col(edge)).norm() < 10 * rounding);
        }
}

TEST_CASE("parallelepiped: edges are those of F, at most a cell long, not flat, not beyond the axis")
{
    auto c = unit::box<2>(4, {1, 1, 0}, {1.2, 1.2, 0});
    auto setup = mpm::make_setup<2>(c);
    mpm::Point<2> point;
    mpm::Vec<2> const place(1, 1);
    auto& F = point.matter.gradient;
    F.topLeftCorner<2, 2>() << 3, 0.5, -0.7, 1.3;
    CHECK((mpm::half_edges(setup, point, place) - 0.25 * F.topLeftCorner<2, 2>()).norm() < rounding);
    F.topLeftCorner<2, 2>() << 9, 0, 0, 1;
    CHECK((mpm::half_edges(setup, point, place) - mpm::Mat<2>(mpm::Vec<2>(1, 0.25).asDiagonal())).norm() < rounding);
    F.topLeftCorner<2, 2>() << 1, 50, 0, 1;
    mpm::Mat<2> const flat = mpm::half_edges(setup, point, place);
    mpm::Vec<2> const one = flat.col(0).normalized(), other = flat.col(1).normalized();
    CHECK(one.dot(other) == close_to(1 - mpm::flattest));
    CHECK(flat.col(1).norm() == close_to(1));
    F(0, 1) = 1e9;
    CHECK((mpm::half_edges(setup, point, place) - mpm::Mat<2>(mpm::Vec<2>(0.25, 1).asDiagonal())).norm() < rounding);
    setup.symmetry = mpm::Symmetry::axial;
    F.topLeftCorner<2, 2>() << 2, 1, 0, 1;
    mpm::Mat<2> const beside = mpm::half_edges(setup, point, mpm::Vec<2>(0.03, 1));
    CHECK(std::abs(beside(0, 0)) + std::abs(beside(0, 1)) == close_to(0.3));
    CHECK(beside(0, 0) == close_to(2 * beside(0, 1)));
}
