#include <doctest/doctest.h>

#include <cmath>
#include <deque>
#include <limits>
#include <vector>

#include "participants/lbm/kernels.hpp"
#include "participants/lbm/still_numbers.hpp"
#include "tests/participants/lbm/unit_config.hpp"

//! Rows of D3Q19 in which solids rest: their own kernel beside those of fluid and of any solids. Lattice units.
namespace {

constexpr std::size_t directions = lbm::Lattice<3>::directions;

//! Populations of rows of so many cells one slot apart, all different, in room for whole registers.
template <class Stored>
struct Lines
{
    std::array<std::vector<Stored>, directions> f{};

    explicit Lines(std::ptrdiff_t slots)
    {
        for (std::size_t q = 0; q < directions; ++q)
            for (std::ptrdiff_t k = 0; k < slots; ++k)
                f[q].push_back(
                    static_cast<Stored>(lbm::Lattice<3>::weight[q] * 0.1 *
                                        std::sin(1.3 * static_cast<double>(k) + 2.9 * static_cast<double>(q * q))));
    }
    lbm::AnySlots<3> from(std::ptrdiff_t slot)
    {
        lbm::AnySlots<3> all;
        for (std::size_t q = 0; q < directions; ++q) all[q] = f[q].data() + slot;
        return all;
    }
};

//! Fractions, weights and open shares of a row's cells, some without solids.
template <class Stored>
struct Solids
{
    std::vector<Stored> fraction, weight, open, none;
    std::vector<char> has_solid;

    //! `covers(x)`: by how much.
    Solids(std::ptrdiff_t cells, double tau, double (*covers)(std::ptrdiff_t))
    {
        for (std::ptrdiff_t x = 0; x < cells; ++x) {
            auto const eps = static_cast<Stored>(covers(x));
            fraction.push_back(eps);
            weight.push_back(lbm::weight_per_fraction(eps, static_cast<Stored>(lbm::flat_drag) * eps, tau));
            open.push_back(lbm::open_share(eps, Stored{}));
            has_solid.push_back(eps > 0);
        }
        none.assign(fraction.size(), Stored{});
    }
    lbm::SolidRow<Stored> row(std::vector<Stored>& rate, std::array<std::vector<Stored>, 3>& force)
    {
        lbm::SolidRow<Stored> row{fraction.data(), weight.data(), open.data(), none.data(), {}, rate.data(), {}};
        for (std::size_t k = 0; k < 3; ++k) row.momentum[k] = none.data(), row.force[k] = force[k].data();
        return row;
    }
};

using Covers = double (*)(std::ptrdiff_t);

//! Rows at once, each covered as its Covers say, against the kernels of cells without and with solids, cell by cell.
//! One slot lies between rows.
template <class Stored>
void check_block(lbm::Config const& c, std::ptrdiff_t cells, std::vector<Covers> const& covers)
{
    constexpr std::ptrdiff_t room = 16;
    auto const kernels = lbm::kernels_of<3>(c);
    auto const relaxation = lbm::relaxation(c);
    bool const les = c.smagorinsky > 0;
    auto const count = static_cast<std::ptrdiff_t>(covers.size()), stride = cells + 1, slots = count * stride + room;
    std::vector<Stored> rate(static_cast<std::size_t>(cells));
    std::array<std::vector<Stored>, 3> told, force;
    for (std::size_t k = 0; k < 3; ++k) told[k].resize(rate.size()), force[k].resize(static_cast<std::size_t>(slots));

    std::vector<Solids<Stored>> solids;
    std::deque<lbm::StillRowNumbers<Stored>> line;
    for (Covers const of_row : covers) {
        solids.emplace_back(cells, relaxation.tau, of_row);
        line.emplace_back(solids.back().row(rate, told), solids.back().has_solid, relaxation, les);
    }
    std::vector<lbm::StillRow> rows;
    std::vector<lbm::StillRun> runs;
    std::vector<Stored> numbers;
    auto const add = [&](std::vector<Stored> const& more) {
        numbers.insert(numbers.end(), more.begin(), more.end());
        return numbers.size() - more.size();
    };
    for (; !line.empty(); line.pop_front()) {
        auto const size = static_cast<std::ptrdiff_t>(line.size());
        std::deque const reached(line.begin(), line.begin() + std::min(size, 1 + lbm::rows_in_reach<Stored>(stride)));
        auto const of_row = lbm::runs_in_line(reached, stride, line[0].of_fluid(relaxation, les), add);
        rows.push_back({static_cast<std::uint32_t>(runs.size()), static_cast<std::uint32_t>(of_row.size())});
        runs.insert(runs.end(), of_row.begin(), of_row.end());
    }
    Lines<Stored> block(slots), silent(slots);
    lbm::StillBlock<Stored> of_rows{cells, count, stride, rows.data(), runs.data(), numbers.data()};
    kernels.still(silent.from(0), of_rows, relaxation);
    of_rows.force = {force[0].data(), force[1].data(), force[2].data()};
    kernels.still(block.from(0), of_rows, relaxation);
    CHECK(silent.f == block.f);  // whether or not it tells forces

    Lines<Stored> fluid(slots), covered(slots), before(slots);
    auto const near = [](Stored a, Stored b) {  // some hundred operations on numbers of 0.01 to 0.1
        return std::abs(a - b) <= 10 * std::numeric_limits<Stored>::epsilon();
    };
    for (std::ptrdiff_t r = 0; r < count; ++r) {
        kernels.fluid(fluid.from(r * stride), {0, cells}, relaxation, {});
        auto& of_row = solids[static_cast<std::size_t>(r)];
        kernels.covered(covered.from(r * stride), {0, cells}, relaxation, of_row.row(rate, told));
        for (std::ptrdiff_t x = 0; x < cells; ++x) {
            CAPTURE(x);
            auto const at = static_cast<std::size_t>(r * stride + x), in_row = static_cast<std::size_t>(x);
            bool const has_solid = of_row.has_solid[in_row] != 0;
            for (std::size_t q = 0; q < directions; ++q) {
                if (has_solid)
                    CHECK(near(block.f[q][at], covered.f[q][at]));
                else
                    CHECK(block.f[q][at] == fluid.f[q][at]);
            }
            for (std::size_t k = 0; k < 3 && has_solid; ++k) CHECK(near(force[k][at], told[k][in_row]));
        }
    }
    for (std::size_t q = 0; q < directions; ++q)  // beyond them all: another thread's
        for (auto k = static_cast<std::size_t>(count * stride - 1); k < block.f[q].size(); ++k)
            CHECK(block.f[q][k] == before.f[q][k]);
}

}  // namespace

TEST_CASE_TEMPLATE("still cells: a block of rows has the fluid's bits without solids, and with them agrees to rounding",
                   Stored, double, float)
{
    using enum lbm::Operator;
    auto c = unit_config<3>({64, 64, 64}, 0.02);
    c.precision = sizeof(Stored) == sizeof(float) ? lbm::Precision::float32 : lbm::Precision::float64;
    Covers const at_ends = [](std::ptrdiff_t x) { return x == 0 ? 1.0 : x == 1 ? 0.3 : x >= 33 ? 0.7 : 0.0; };
    Covers const within = [](std::ptrdiff_t x) { return x == 9 || x == 12 ? 0.6 : x == 31 ? 1.2 : 0.0; };
    Covers const all_over = [](std::ptrdiff_t x) { return x % 2 == 0 ? 0.9 : 1.0; };
    Covers const nowhere = [](std::ptrdiff_t) { return 0.0; };
    auto const check = [&] {
        for (std::ptrdiff_t const cells : {35, 40, 48}) {
            CAPTURE(cells);
            for (Covers const alike : {at_ends, within, all_over, nowhere})
                check_block<Stored>(c, cells, std::vector(5, alike));
            check_block<Stored>(c, cells, {nowhere, at_ends, all_over, nowhere, all_over, at_ends, within, nowhere});
            check_block<Stored>(c, cells, {all_over, all_over, at_ends, at_ends});
        }
        for (std::ptrdiff_t const cells : {1, 3, 7})  // a register has cells of several rows
            check_block<Stored>(c, cells, {nowhere, all_over, all_over, at_ends, nowhere, within, at_ends, all_over});
    };
    for (bool const force : {false, true}) {
        if (force) c.acceleration = {1e-3, -2e-3, 3e-3};
        for (auto const collision : {trt, bgk, mrt}) {
            c.collision = collision;
            check();
        }
        c.smagorinsky = 0.1;
        check();
        c.smagorinsky = 0;
    }
}
