#include <doctest/doctest.h>

#include <cmath>
#include <cstdio>
#include <tuple>

#include "tests/verification/error_table.hpp"
#include "tests/verification/mpm/collapse.hpp"
#include "tests/verification/mpm/manufactured.hpp"
#include "tests/verification/mpm/self_weight.hpp"

//! Errors of a column under its own weight, of a manufactured solution and of a collapse against the time that they
//! take, at four resolutions, by basis and width of the points.
using namespace verification;

namespace {

struct Way
{
    char const* name;
    mpm::BasisKind basis;
    mpm::Width width;
};

}  // namespace

//! Minutes: only `./dev verify` runs it. Marks: those of the cases, for gimp.
TEST_CASE("errors: of a continuum, against the time to get them" * doctest::skip())
{
    using enum mpm::BasisKind;
    using enum mpm::Width;
    ErrorTable table("mpm");
    auto const mark = [](Way const& way, double of_gimp) { return way.basis == gimp ? of_gimp : 0; };
    for (Way const& way : {Way{"gimp", gimp, fixed},
                           {"gimp, width: stretch", gimp, stretch},
                           {"spline", spline, fixed},
                           {"cpdi", cpdi, fixed},
                           {"linear", linear, fixed}})
        table.add("M03 own weight", way.name, {8, 16, 32, 64}, mark(way, 0.03), [&](int cells) {
            double settlement = 0;
            return self_weight_error(way.basis, way.width, cells, settlement);
        });
    for (Way const& way : {Way{"gimp", gimp, fixed},
                           {"gimp, width: stretch", gimp, stretch},
                           {"spline", spline, fixed},
                           {"cpdi", cpdi, fixed}})
        table.add("M09 manufactured", way.name, {8, 16, 32, 64}, mark(way, 0.02), [&](int cells) {
            return manufactured::rms_deviation(manufactured::true_strain(), cells, mpm::Scheme::musl, true, way.width,
                                               way.basis);
        });
    auto const run_out = [](Column const& column) {
        auto solver = column.solver();
        column.let_go(solver, [] {});
        return column.run_out(solver).front / Column::width - 1;
    };
    double const finest = run_out({0.8, 80});
    std::printf("D11 run-out a = 0.8, gimp, 80 cells across: %.4f\n", finest);
    for (auto const& [name, shared, basis] :
         {std::tuple{"gimp", true, gimp}, {"gimp, shared_volume: false", false, gimp}, {"spline", true, spline}})
        table.add("D11 run-out a = 0.8", name, {5, 10, 20, 40}, 0, [&](int cells) {
            return std::abs(run_out({0.8, cells, shared, basis}) / finest - 1);
        });
}
