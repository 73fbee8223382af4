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
constexpr lbm::Surface cut = lbm::Surface::interpolated;
constexpr Named operators[] = {
    {"bgk", {.collision = lbm::Operator::bgk}},
    {"trt", {.collision = lbm::Operator::trt}},
    {"mrt", {.collision = lbm::Operator::mrt}},
    {"trt, single", {.collision = lbm::Operator::trt, .precision = lbm::Precision::float32}}};
constexpr Named surfaces_too[] = {{"trt, interpolated", {.collision = lbm::Operator::trt, .surface = cut}},
                                  {"mrt, interpolated", {.collision = lbm::Operator::mrt, .surface = cut}}};

class Table
{
 public:
    //! `error(cells, variant)` for all ways, those with other surfaces only where there are bodies.
    template <class Error>
    void add(char const* what, std::initializer_list<int> resolutions, bool bodies, double mark, Error&& error)
    {
        for (Named const& way : operators) add_way(what, way, resolutions, mark, error);
        for (Named const& way : surfaces_too)
            if (bodies) add_way(what, way, resolutions, mark, error);
    }

    //! The same for one way. No marks for bgk: with it the place of a surface depends on tau.
    template <class Error>
    void add_way(char const* what, Named const& way, std::initializer_list<int> resolutions, double mark, Error&& error)
    {
        bool const marked = way.variant.collision != lbm::Operator::bgk;
        table_.add(what, way.name, resolutions, marked ? mark : 0,
                   [&](int cells) { return error(cells, way.variant); });
    }

 private:
    verification::ErrorTable table_{"lbm"};
};

}  // namespace

//! Minutes: only `./dev verify` runs it. Marks: those of the cases.
TEST_CASE("errors: against the time to get them" * doctest::skip())
{
    Table table;
    table.add("L06 array of discs", {5, 7, 10, 14, 20, 28}, true, 0.01, [](int d, Variant const& variant) {
        auto const side = static_cast<std::ptrdiff_t>(std::lround(d / std::sqrt(0.8 / std::numbers::pi)));
        double const diameter = static_cast<double>(side) * std::sqrt(0.8 / std::numbers::pi);
        return relative(disc_array_drag(side, diameter, 1, {0.13, 0.37}, 0.6, variant), 51.52694896);
    });
    table.add("L07 array of spheres", {6, 8, 12, 16}, true, 0.02, [](int d, Variant const& variant) {
        auto const side = static_cast<std::ptrdiff_t>(std::lround(d / std::cbrt(6 * 0.216 / std::numbers::pi)));
        double const diameter = static_cast<double>(side) * std::cbrt(6 * 0.216 / std::numbers::pi);
        return relative(sphere_array_drag(side, diameter, 0.8, Made::analytic, variant), 7.4419536);
    });
    table.add("L04 cavity Re 400", {24, 32, 48, 64, 96}, false, 0.006, [](int n, Variant const& variant) {
        return cavity_error(cavities()[1], n, 3.2 / n, variant);  // the lid's speed with the cell
    });
    table.add("L05 cylinder Re 20 c_D", {10, 20, 30, 40}, true, 0.01,
              [](int d, Variant const& variant) { return relative(steady_cylinder(d, variant).drag, 5.57953523); });
    Variant const trt{.collision = lbm::Operator::trt};
    for (Named const& way : {Named{"trt", trt}, {"mrt", {}}, operators[3]})
        table.add_way("C02 sphere E4", way, {3, 6, 9, 12}, 0.009, [](int d, Variant const& variant) {
            return relative(settle(e4, d, variant).fastest, e4.fastest);
        });
}
