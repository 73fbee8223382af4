#include <doctest/doctest.h>

#include <cmath>
#include <initializer_list>
#include <numbers>

#include "tests/verification/error_table.hpp"
#include "tests/verification/lbm/cavity.hpp"
#include "tests/verification/lbm/channel_cylinder.hpp"
#include "tests/verification/lbm/disc_array.hpp"
#include "tests/verification/lbm/settling.hpp"
#include "tests/verification/lbm/sphere_array.hpp"

//! Errors of five flows against the time that they take, at four resolutions or more, for each operator, boundary
//! method and precision.
using namespace lattice_case;

namespace {

struct Named
{
    char const* name;
    Variant variant;
};
constexpr Named all_operators[] = {
    {"bgk", {.collision = lbm::Operator::bgk}},
    {"trt", {.collision = lbm::Operator::trt}},
    {"mrt", {.collision = lbm::Operator::mrt}},
    {"central", {.collision = lbm::Operator::central}},
    {"trt, single", {.collision = lbm::Operator::trt, .precision = lbm::Precision::float32}}};
constexpr Named other_surfaces[] = {
    {"trt, interpolated", {.collision = lbm::Operator::trt, .surface = lbm::Surface::interpolated}},
    {"mrt, interpolated", {.collision = lbm::Operator::mrt, .surface = lbm::Surface::interpolated}},
    {"trt, forced", {.collision = lbm::Operator::trt, .surface = lbm::Surface::forced}}};

struct Marks  //!< [-]; 0: none
{
    double covered, interpolated = covered;

    //! Of the other ways none: with them the place of a surface depends on tau.
    double of(Variant const& way) const
    {
        if (way.collision != lbm::Operator::trt && way.collision != lbm::Operator::mrt) return 0;
        if (way.surface == lbm::Surface::forced) return 0;
        return way.surface == lbm::Surface::covered ? covered : interpolated;
    }
};

class Table
{
 public:
    //! `error(cells, variant)` for all ways, those with other surfaces only where there are bodies.
    template <class Error>
    void add(char const* what, std::initializer_list<int> resolutions, bool bodies, Marks const& marks, Error&& error)
    {
        auto const add_way = [&](Named const& way) {
            table_.add(what, way.name, resolutions, marks.of(way.variant),
                       [&](int cells) { return error(cells, way.variant); });
        };
        for (Named const& way : all_operators) add_way(way);
        for (Named const& way : other_surfaces)
            if (bodies) add_way(way);
    }

 private:
    verification::ErrorTable table_{"lbm"};
};

}  // namespace

//! Minutes: only `./dev verify` runs it. Marks: those of the cases; of the sphere with interpolated surfaces that of
//! codes with 15 to 24 cells a diameter, 2.5 to 4 %.
TEST_CASE("errors: against the time to get them" * doctest::skip())
{
    Table table;
    table.add("L06 array of discs", {5, 7, 10, 14, 20, 28}, true, {0.01}, [](int d, Variant const& variant) {
        auto const side = static_cast<std::ptrdiff_t>(std::lround(d / std::sqrt(0.8 / std::numbers::pi)));
        double const diameter = static_cast<double>(side) * std::sqrt(0.8 / std::numbers::pi);
        return relative(disc_array_drag(side, diameter, 1, {0.13, 0.37}, 0.6, variant), 51.52694896);
    });
    table.add("L07 array of spheres", {6, 8, 12, 16}, true, {0.02}, [](int d, Variant const& variant) {
        auto const side = static_cast<std::ptrdiff_t>(std::lround(d / std::cbrt(6 * 0.216 / std::numbers::pi)));
        double const diameter = static_cast<double>(side) * std::cbrt(6 * 0.216 / std::numbers::pi);
        return relative(sphere_array_drag(side, diameter, 0.8, Made::analytic, variant), 7.4419536);
    });
    table.add("L04 cavity Re 400", {24, 32, 48, 64, 96}, false, {0.006}, [](int n, Variant const& variant) {
        return cavity_error(cavities()[1], n, 3.2 / n, variant);  // the lid's speed with the cell
    });
    table.add("L05 cylinder Re 20 c_D", {10, 20, 30, 40}, true, {0.01},
              [](int d, Variant const& variant) { return relative(steady_cylinder(d, variant).drag, 5.57953523); });
    table.add("C02 sphere E4", {3, 6, 9, 12, 15}, true, {0.009, 0.03},
              [](int d, Variant const& variant) { return relative(settle(e4, d, variant).fastest, e4.fastest); });
}
