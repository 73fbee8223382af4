#include "participants/mpm/basis.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <random>

#include "participants/mpm/stencil.hpp"

namespace {

constexpr double rounding = 1e-14;

//! Sum over the nodes that a point at x reaches of f(node, weight, slope).
template <class Basis, class Each>
double sum_at(Basis const& basis, double x, Each&& each)
{
    double sum = 0;
    for (int j = 0; j < Basis::width; ++j) {
        int const node = basis.first(x) + j;
        sum += each(node, basis.value(x - node), basis.slope(x - node));
    }
    return sum;
}

template <class Basis>
void check(Basis const& basis)
{
    std::mt19937 random(1);
    std::uniform_real_distribution<double> anywhere(0, 7);
    for (int k = 0; k < 10000; ++k) {
        double const x = k < 29 ? 0.25 * k : anywhere(random);  // also at nodes and sides
        CHECK(std::abs(sum_at(basis, x, [](int, double w, double) { return w; }) - 1) < rounding);
        CHECK(std::abs(sum_at(basis, x, [](int, double, double s) { return s; })) < rounding);
        CHECK(std::abs(sum_at(basis, x, [](int i, double w, double) { return w * i; }) - x) < 10 * rounding);
        CHECK(std::abs(sum_at(basis, x, [](int i, double, double s) { return s * i; }) - 1) < 10 * rounding);
        for (int j = -2; j < 3 + Basis::width; ++j) {  // what a point does not reach has no weight
            double const d = x - (basis.first(x) + j);
            if (j < 0 || j >= Basis::width) CHECK(basis.value(d) == 0);
            CHECK(basis.value(d) >= 0);
        }
    }
    for (double d = -1.9; d < 1.9; d += 0.0137) {  // slope is the derivative
        double const h = 1e-6, difference = (basis.value(d + h) - basis.value(d - h)) / (2 * h);
        CHECK(std::abs(basis.slope(d) - difference) < 1e-5);
    }
}

}  // namespace

TEST_CASE("basis: hat functions sum to 1 and reproduce a linear field")
{
    check(mpm::Linear(0.25));
}

TEST_CASE("basis: gimp sums to 1 and reproduces a linear field, one to four points a cell")
{
    for (double half_width : {0.5, 0.25, 1.0 / 6, 0.125}) check(mpm::Gimp(half_width));
}

TEST_CASE("basis: splines sum to 1 and reproduce a linear field")
{
    check(mpm::Spline(0.25));
}

TEST_CASE("basis: gimp is the hat averaged over the width of the point")
{
    mpm::Gimp const gimp(0.25);
    mpm::Linear const hat(0);
    int const parts = 2000;
    for (double d = -1.5; d <= 1.5; d += 0.01) {
        double mean = 0;
        for (int k = 0; k < parts; ++k) mean += hat.value(d + 0.25 * (2 * (k + 0.5) / parts - 1)) / parts;
        CHECK(std::abs(gimp.value(d) - mean) < 1e-6);
    }
}

TEST_CASE("stencil: a product of axes reproduces a linear field of the plane and of space")
{
    auto const check_dimension = [](auto dimension) {
        constexpr int D = dimension;
        std::array<int, D> cells;
        cells.fill(4);
        mpm::Grid<D> grid(cells);
        mpm::Vec<D> place;
        for (int k = 0; k < D; ++k) place[k] = 1.3 + 0.7 * k;
        double const cell = 0.5;
        mpm::Stencil<D, mpm::Gimp> const at(mpm::Vec<D>::Constant(0.25), place, cell);
        double sum = 0;
        mpm::Vec<D> mean = mpm::Vec<D>::Zero();
        mpm::Mat<D> gradient = mpm::Mat<D>::Zero();
        at.each(grid, [&](mpm::Node<D>& node, double weight, mpm::Vec<D> const& slope) {
            mpm::Vec<D> x;
            for (int k = 0; k < D; ++k) x[k] = node.index[static_cast<std::size_t>(k)] * cell;
            sum += weight;
            mean += weight * x;
            gradient += x * slope.transpose();
        });
        CHECK(std::abs(sum - 1) < rounding);
        CHECK((mean - cell * place).norm() < 10 * rounding);
        CHECK((gradient - mpm::Mat<D>::Identity()).norm() < 10 * rounding);
        CHECK(grid.nodes().size() == (D == 2 ? 9 : 27));
    };
    check_dimension(std::integral_constant<int, 2>());
    check_dimension(std::integral_constant<int, 3>());
}
