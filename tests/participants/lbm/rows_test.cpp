#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "participants/lbm/kernels.hpp"
#include "participants/lbm/solver.hpp"
#include "tests/participants/lbm/unit_config.hpp"

//! Rows that collide in one go, and what leaves them at their ends. Lattice units.
namespace {

//! Rows of so many cells one slot apart in each direction's array, all different.
template <int D, class Stored>
struct Lines
{
    static constexpr std::size_t directions = lbm::Lattice<D>::directions;
    std::ptrdiff_t cells, stride = cells + 1;
    std::array<std::vector<Stored>, directions> f{};

    Lines(std::ptrdiff_t n, std::ptrdiff_t rows) : cells(n)
    {
        for (std::size_t q = 0; q < directions; ++q)
            for (std::ptrdiff_t k = 0; k < rows * stride; ++k)
                f[q].push_back(
                    static_cast<Stored>(lbm::Lattice<D>::weight[q] * 0.1 *
                                        std::sin(1.3 * static_cast<double>(k) + 2.9 * static_cast<double>(q * q))));
    }
    lbm::AnySlots<D> row(std::ptrdiff_t r)
    {
        lbm::AnySlots<D> all;
        for (std::size_t q = 0; q < directions; ++q) all[q] = f[q].data() + r * stride;
        return all;
    }
};

template <int D, class Stored>
void check_lines(lbm::Operator collision, double smagorinsky)
{
    auto c = unit_config<D>({64, 64, D == 3 ? 64.0 : 0.0}, 0.01);
    c.collision = collision;
    c.smagorinsky = smagorinsky;
    c.precision = sizeof(Stored) == sizeof(float) ? lbm::Precision::float32 : lbm::Precision::float64;
    auto const kernel = lbm::kernels_of<D>(c).fluid;
    constexpr std::ptrdiff_t rows = 3;
    for (std::ptrdiff_t const cells : {1, 7, 8, 15, 16, 35, 48}) {
        CAPTURE(cells);
        Lines<D, Stored> together(cells, rows), apart(cells, rows), before(cells, rows);
        kernel(together.row(0), {0, cells, rows, together.stride}, lbm::relaxation(c), {});
        for (std::ptrdiff_t r = 0; r < rows; ++r) kernel(apart.row(r), {0, cells}, lbm::relaxation(c), {});
        auto const at = [&](std::ptrdiff_t r, std::ptrdiff_t x) {
            return static_cast<std::size_t>(r * together.stride + x);
        };
        for (std::size_t q = 0; q < together.f.size(); ++q) {
            CHECK(together.f[q].back() == before.f[q].back());  // beyond them all: another thread's
            for (std::ptrdiff_t r = 0; r < rows; ++r)
                for (std::ptrdiff_t x = 0; x < cells; ++x) CHECK(together.f[q][at(r, x)] == apart.f[q][at(r, x)]);
        }
        CHECK(together.f != before.f);
    }
}

//! Puts other populations into cells that are about to be read, and keeps what has been written by then.
template <int D, class Stored>
struct Change : lbm::OnTheWay
{
    Lines<D, Stored>& lines;
    std::ptrdiff_t at = -1;
    std::array<std::vector<Stored>, Lines<D, Stored>::directions> written{};

    Change(Lines<D, Stored>& of, std::ptrdiff_t from)
        : OnTheWay{from, [](OnTheWay& self, std::ptrdiff_t now) { static_cast<Change&>(self).meet(now); }}, lines(of)
    {}
    void meet(std::ptrdiff_t now)
    {
        constexpr auto two_registers = static_cast<std::ptrdiff_t>(2 * lbm::Lanes<Stored>::count);
        at = now;
        for (std::size_t q = 0; q < written.size(); ++q)
            written[q].assign(lines.f[q].begin(), lines.f[q].begin() + std::max<std::ptrdiff_t>(at - two_registers, 0));
        change(lines);
        due = std::numeric_limits<std::ptrdiff_t>::max();
    }
    void change(Lines<D, Stored>& of) const
    {
        for (std::size_t q = 0; q < of.f.size(); ++q)
            for (auto k = static_cast<std::size_t>(at); k < of.f[q].size(); ++k) of.f[q][k] *= Stored(0.5);
    }
};

template <int D, class Stored>
void check_changes(lbm::Operator collision)
{
    auto c = unit_config<D>({64, 64, D == 3 ? 64.0 : 0.0}, 0.01);
    c.collision = collision;
    c.precision = sizeof(Stored) == sizeof(float) ? lbm::Precision::float32 : lbm::Precision::float64;
    auto const kernel = lbm::kernels_of<D>(c).fluid;
    constexpr std::ptrdiff_t rows = 3;
    for (std::ptrdiff_t const cells : {35, 48})
        for (std::ptrdiff_t const from : {-3, 0, 20, 47, 60, 96}) {
            CAPTURE(cells);
            CAPTURE(from);
            Lines<D, Stored> meanwhile(cells, rows), before(cells, rows);
            Change<D, Stored> change(meanwhile, from);
            kernel(meanwhile.row(0), {0, cells, rows, meanwhile.stride, &change}, lbm::relaxation(c), {});
            REQUIRE(change.at >= from);
            change.change(before);
            kernel(before.row(0), {0, cells, rows, before.stride}, lbm::relaxation(c), {});
            CHECK(meanwhile.f == before.f);
            for (std::size_t q = 0; q < before.f.size(); ++q)
                CHECK(std::equal(change.written[q].begin(), change.written[q].end(), before.f[q].begin()));
        }
}

//! Velocities along y of a channel that is driven, so many cells wide: periodic across x, nothing depends on it.
template <int D>
std::vector<double> channel(double width, lbm::Precision precision)
{
    auto c = unit_config<D>({width, 12, D == 3 ? 5.0 : 0.0}, 0.05);
    c.precision = precision;
    c.acceleration = {1e-4, 0, 0};
    for (auto const side : {lbm::left, lbm::right, lbm::lower_z, lbm::upper_z})
        if (D == 3 || side < lbm::lower_z) c.walls[side].kind = lbm::Border::periodic;
    lbm::Solver<D> solver(c);
    for (int k = 0; k < 300; ++k) solver.step();  // slack along x is used up after 128
    auto const all = solver.fields(1);
    std::vector<double> along;
    for (std::ptrdiff_t y = 0; y < all.ny; ++y)
        for (std::size_t k = 0; k < D; ++k) along.push_back(all.velocity[static_cast<std::size_t>(y * all.nx) * D + k]);
    return along;
}

}  // namespace

TEST_CASE_TEMPLATE("rows: several in one go become what each becomes alone, and nothing beyond them is touched", Stored,
                   double, float)
{
    using enum lbm::Operator;
    check_lines<2, Stored>(mrt, 0);
    check_lines<2, Stored>(mrt, 0.1);
    check_lines<2, Stored>(central, 0);
    check_lines<3, Stored>(trt, 0);
    check_lines<3, Stored>(mrt, 0);
    check_lines<3, Stored>(mrt, 0.1);
    check_lines<3, Stored>(central, 0);
}

TEST_CASE_TEMPLATE("rows: what is done on the way comes before cells are read, two registers after they are written",
                   Stored, double, float)
{
    using enum lbm::Operator;
    check_changes<2, Stored>(mrt);
    check_changes<3, Stored>(trt);
    check_changes<3, Stored>(mrt);
    check_changes<3, Stored>(central);
}

TEST_CASE("rows: a channel of one or two cells across a periodic side is that of many, bit for bit")
{
    for (auto const precision : {lbm::Precision::float64, lbm::Precision::float32}) {
        auto const plane = channel<2>(21, precision), space = channel<3>(21, precision);
        REQUIRE(plane[12] > 1e-3);
        for (double const width : {1.0, 2.0}) {
            CHECK(channel<2>(width, precision) == plane);
            CHECK(channel<3>(width, precision) == space);
        }
    }
}
