#include "coupler/schedule/acceleration.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <random>
#include <string>

#include "coupler/base/error.hpp"
#include "tests/coupler/schedule/fixed_point.hpp"
#include "tests/support/close_to.hpp"

using sluice::AccelerationBlock;
using sluice::AccelerationConfig;
using sluice::AccelerationStep;
using sluice::Error;
using sluice::Exit;
using sluice::Verdict;
using Columns = AccelerationBlock::Columns;
using Ids = std::vector<std::int64_t>;
using Method = AccelerationConfig::Method;
using Summaries = std::vector<std::vector<double>>;

namespace {

//! A vector of two numbers a point and a scalar.
AccelerationConfig two_columns(Method method = Method::iqn_ils)
{
    return {.method = method,
            .columns = {{.name = "load.force", .tolerance = 1e-3}, {.name = "load.torque", .tolerance = 1e-1}}};
}

AccelerationBlock block_of(AccelerationConfig const& config, int number = 0)
{
    return AccelerationBlock(config, number, {{.joint = 0, .components = 2}, {.joint = 1, .components = 1}});
}

//! A window of two iterations, so that there is one difference: results `a`, then `b`, inputs 0.
void make_history(AccelerationBlock& block, Ids const& ids, Columns const& a, Columns const& b)
{
    Columns const zero = {std::vector<double>(2 * ids.size(), 0.0), std::vector<double>(ids.size(), 0.0)};
    block.begin_window(ids);
    block.summary(zero, a);
    block.summary(zero, b);
    block.accept();
}

template <class Act>
void check_error(Exit exit, std::string const& says, Act&& act)
{
    try {
        act();
        FAIL("no Error");
    } catch (Error const& error) {
        CHECK(error.exit() == exit);
        CHECK_MESSAGE(std::string(error.what()).find(says) != std::string::npos, error.what());
    }
}

}  // namespace

TEST_CASE("acceleration: differences follow their points when these are reordered, new and gone")
{
    AccelerationBlock block = block_of(two_columns());
    make_history(block, {10, 20, 30}, {{1, 2, 3, 4, 5, 6}, {7, 8, 9}}, {{2, 4, 6, 8, 10, 12}, {21, 24, 27}});
    // W: results of the second iteration less those of the first
    Columns const w = {{1, 2, 3, 4, 5, 6}, {14, 16, 18}};

    block.begin_window(Ids{30, 40, 10});  // 20 is gone, 40 is new
    Columns const used = {std::vector<double>(6, 1.0), std::vector<double>(3, 1.0)};
    Columns const result = {{1.5, 2.5, 3.5, 4.5, 5.5, 6.5}, {7.5, 8.5, 9.5}};
    Columns next;
    AccelerationStep const step = block.next(Summaries{block.summary(used, result)}, next);
    REQUIRE(step.coefficients.size() == 1);
    double const c = step.coefficients[0];
    CHECK(c != 0);
    CHECK(next[0] ==
          std::vector<double>{1.5 + c * w[0][4], 2.5 + c * w[0][5], 3.5, 4.5, 5.5 + c * w[0][0], 6.5 + c * w[0][1]});
    CHECK(next[1] == std::vector<double>{7.5 + c * w[1][2], 8.5, 9.5 + c * w[1][0]});
}

TEST_CASE("acceleration: the coefficient of a single difference is that of the weighted projection")
{
    AccelerationBlock block = block_of(two_columns());
    make_history(block, {1}, {{1, 0}, {0}}, {{4, 4}, {10}});  // V = W = (3, 4), (10)
    block.begin_window(Ids{1});
    Columns next;
    AccelerationStep const step = block.next(Summaries{block.summary({{0, 0}, {0}}, {{6, 8}, {5}})}, next);
    // scales: |x~| = 10 and |V| = 10; r = (6, 8), (5); <V, r> = (18 + 32) / 100 + 50 / 100, <V, V> = 25 / 100 + 1
    CHECK(step.coefficients[0] == close_to(-1.0 / 1.25).epsilon(1e-14));
}

TEST_CASE("acceleration: history is as many windows as it says")
{
    for (int const history : {0, 1, 2}) {
        AccelerationConfig config = two_columns();
        config.history = history;
        AccelerationBlock block = block_of(config);
        for (int w = 0; w < 4; ++w) {
            double const x = 1 + w;
            make_history(block, {1}, {{x, 1}, {x * x}}, {{2 * x, 5}, {3}});
        }
        block.begin_window(Ids{1});
        Columns next;
        AccelerationStep const step = block.next(Summaries{block.summary({{0, 0}, {0}}, {{1, 2}, {3}})}, next);
        CHECK(step.coefficients.size() == static_cast<std::size_t>(history));
        CHECK((step.relaxation != 0) == (history == 0));
    }
}

TEST_CASE("acceleration: a difference that is 99.9 % known, or as small as rounding, is dropped")
{
    AccelerationConfig const config{.columns = {{.name = "load.force"}}};
    auto kept = [&](Columns const& older, Columns const& newer) {
        AccelerationBlock block(config, 0, {{.joint = 0, .components = 2}});
        Columns const zero = {{0, 0}};
        for (Columns const& difference : {older, newer}) {
            block.begin_window(Ids{1});
            block.summary(zero, zero);
            block.summary(zero, difference);
            block.accept();
        }
        block.begin_window(Ids{1});
        Columns next;
        return block.next(Summaries{block.summary(zero, {{0.5, 0.5}})}, next).kept;
    };
    using Kept = std::vector<std::size_t>;
    CHECK(kept({{1, 5e-3}}, {{1, 0}}) == Kept{0, 1});  // newest first
    CHECK(kept({{1, 5e-4}}, {{1, 0}}) == Kept{0});
    CHECK(kept({{1, 0}}, {{0, 1e-11}}) == Kept{0, 1});
    CHECK(kept({{1, 0}}, {{0, 1e-13}}) == Kept{1});
}

TEST_CASE("acceleration: more differences than unknowns, and more than a hundred, do no harm")
{
    AccelerationConfig config{.history = 1000, .columns = {{.name = "signal.value"}}};
    AccelerationBlock block(config, 0, {{.joint = 0, .components = 2}});
    std::mt19937 random(1);
    block.begin_window(Ids{1});
    block.summary({{0, 0}}, {{0, 0}});
    for (int i = 0; i < 150; ++i) block.summary({{0, 0}}, {fixed_point::random_vector(2, random)});
    Columns next;
    AccelerationStep const step = block.next(Summaries{block.summary({{0, 0}}, {{1, 1}})}, next);
    CHECK(step.coefficients.size() == 100);
    CHECK(step.kept == std::vector<std::size_t>{0, 1});  // the newest two span the plane
}

TEST_CASE("acceleration: a column has converged by its own tolerance, or below its floor")
{
    AccelerationConfig config = two_columns(Method::constant);
    config.columns[1].floor = 1e-9;
    auto verdict = [&](Columns const& used, Columns const& result) {
        AccelerationBlock block = block_of(config);
        block.begin_window(Ids{5});
        return sluice::judge(config, Summaries{block.summary(used, result)});
    };
    Verdict v = verdict({{3, 4.004}, {1.05}}, {{3, 4}, {1}});  // 0.8e-3 of 5, 0.05 of 1
    CHECK(v.converged);
    CHECK(v.columns[0].residual == close_to(0.004));
    CHECK(v.columns[0].result == close_to(5));
    v = verdict({{3, 4.006}, {1.05}}, {{3, 4}, {1}});  // 1.2e-3 of 5
    CHECK_FALSE(v.converged);
    CHECK_FALSE(v.columns[0].converged);
    CHECK(v.columns[1].converged);
    v = verdict({{3, 4}, {1.2}}, {{3, 4}, {1}});
    CHECK_FALSE(v.converged);
    CHECK_FALSE(v.columns[1].converged);
    CHECK(verdict({{0, 0}, {0}}, {{0, 0}, {0}}).converged);
    CHECK(verdict({{0, 0}, {2e-10}}, {{0, 0}, {-7e-10}}).converged);  // noise below 1e-9
    CHECK_FALSE(verdict({{0, 0}, {2e-9}}, {{0, 0}, {-7e-9}}).converged);
}

TEST_CASE("acceleration: columns are judged over all blocks together")
{
    AccelerationConfig const config = two_columns(Method::constant);
    Summaries summaries;
    for (int b = 0; b < 2; ++b) {
        AccelerationBlock block = block_of(config, b);
        block.begin_window(Ids{b});
        double const x = b == 0 ? 3 : 4;
        summaries.push_back(block.summary({{0, 0}, {0}}, {{x, 0}, {2 * x}}));
    }
    Verdict const v = sluice::judge(config, summaries);
    CHECK(v.columns[0].residual == close_to(5).epsilon(1e-15));
    CHECK(v.columns[1].result == close_to(10).epsilon(1e-15));
}

TEST_CASE("acceleration: a residual of zero stays where it is")
{
    for (Method const method : {Method::constant, Method::aitken, Method::iqn_ils})
        for (double const x : {0.0, 1.5}) {
            AccelerationConfig const config = two_columns(method);
            AccelerationBlock block = block_of(config);
            Columns const point = {{x, 0}, {2 * x}};
            Columns next = point;
            block.begin_window(Ids{1});
            for (int k = 0; k < 3; ++k) {
                Summaries const summaries = {block.summary(next, point)};
                CHECK(sluice::judge(config, summaries).converged);
                block.next(summaries, next);
                CHECK(next == point);
            }
        }
}

TEST_CASE("acceleration: blocks without points take part")
{
    AccelerationConfig const config = two_columns();
    AccelerationBlock full = block_of(config, 0), empty = block_of(config, 1);
    full.begin_window(Ids{1});
    empty.begin_window(Ids{});
    Columns x = {{0, 0}, {0}}, none = {{}, {}};
    for (int k = 0; k < 4; ++k) {
        Columns const result = {{1 - 2 * x[0][0], 1 + 0.5 * x[0][1]}, {3 - 4 * x[1][0]}};
        Summaries const summaries = {full.summary(x, result), empty.summary({{}, {}}, {{}, {}})};
        AccelerationStep const a = full.next(summaries, x), b = empty.next(summaries, none);
        CHECK(fixed_point::same_bits(a.coefficients, b.coefficients));
    }
    CHECK(x[0][0] == close_to(1.0 / 3));
    CHECK(x[0][1] == close_to(2.0));
    CHECK(x[1][0] == close_to(0.6));
    CHECK(none == Columns{{}, {}});
}

TEST_CASE("acceleration: a number that is not finite ends the run and is named")
{
    for (double const bad : {std::nan(""), std::numeric_limits<double>::infinity()}) {
        AccelerationBlock block = block_of(two_columns());
        block.begin_window(Ids{10, 20});
        Columns const good = {{1, 2, 3, 4}, {5, 6}};
        check_error(Exit::numerical, "load.force of point 20", [&] { block.summary(good, {{1, 2, 3, bad}, {5, 6}}); });
        check_error(Exit::numerical, "load.torque of point 10", [&] { block.summary({{1, 2, 3, 4}, {bad, 6}}, good); });
    }
}

TEST_CASE("acceleration: a norm that overflows ends the run in every member")
{
    AccelerationConfig const config = two_columns();
    AccelerationBlock block = block_of(config);
    block.begin_window(Ids{1});
    Summaries const summaries = {block.summary({{0, 0}, {0}}, {{1e200, 0}, {1}})};
    check_error(Exit::numerical, "load.force", [&] { sluice::judge(config, summaries); });
}

TEST_CASE("acceleration: summaries that do not belong together are refused")
{
    AccelerationConfig const config = two_columns();
    std::vector<AccelerationBlock> blocks = {block_of(config, 0), block_of(config, 1)};
    Summaries good;
    for (auto& block : blocks) {
        make_history(block, {1}, {{1, 2}, {3}}, {{4, 4}, {4}});
        block.begin_window(Ids{1});
        good.push_back(block.summary({{0, 0}, {0}}, {{1, 0}, {1}}));
    }
    CHECK_NOTHROW(sluice::judge(config, good));
    auto refused = [&](Summaries const& summaries) {
        check_error(Exit::protocol, "same iteration of the same group", [&] { sluice::judge(config, summaries); });
    };
    refused({});
    refused({good[1], good[0]});
    refused({good[0], good[0]});
    refused({good[0], blocks[1].summary({{0, 0}, {0}}, {{1, 0}, {1}})});  // one iteration further
    for (std::size_t length = 0; length < good[1].size(); ++length)       // cut off anywhere
        refused({good[0], {good[1].begin(), good[1].begin() + static_cast<std::ptrdiff_t>(length)}});
    Summaries longer = good;
    longer[1].push_back(0);
    refused(longer);
    for (std::size_t field = 0; field < 5; ++field)  // the header is not what it should be
        for (double const bad : {-1.0, 0.5, 1e300, std::nan("")}) {
            Summaries changed = good;
            changed[1][field] = bad;
            refused(changed);
        }
    Summaries histories;  // of the same iteration
    for (int b = 0; b < 2; ++b) {
        AccelerationBlock block = block_of(config, b);
        if (b == 1) make_history(block, {1}, {{1, 2}, {3}}, {{4, 4}, {4}});
        block.begin_window(Ids{1});
        histories.push_back(block.summary({{0, 0}, {0}}, {{1, 0}, {1}}));
    }
    refused(histories);
    AccelerationConfig other = config;
    other.method = Method::aitken;
    check_error(Exit::protocol, "another method", [&] { sluice::judge(other, good); });
}

TEST_CASE("acceleration: a restored block goes on as if nothing had been")
{
    for (Method const method : {Method::aitken, Method::iqn_ils}) {
        AccelerationConfig config = two_columns(method);
        config.relaxation = 0.9;  // above what Aitken finds
        auto map = [](Columns const& x, double shift) {
            return Columns{{shift - 1.5 * x[0][0] + 0.1 * x[1][0], 2 - 0.7 * x[0][1]}, {shift - 3 * x[1][0] + x[0][1]}};
        };
        auto window = [&](AccelerationBlock& block, double shift) {
            Columns x = {{0, 0}, {0}};
            block.begin_window(Ids{7});
            for (int k = 0; k < 3; ++k) block.next(Summaries{block.summary(x, map(x, shift))}, x);
            block.accept();
            return x;
        };
        AccelerationBlock block = block_of(config);
        window(block, 1.0);
        window(block, 1.3);
        AccelerationBlock copy = block_of(config), fresh = block_of(config);
        copy.restore(block.save());
        fresh.restore(fresh.save());  // of a run that has not begun
        Columns const expected = window(block, 1.7);
        CHECK(window(copy, 1.7) == expected);
        CHECK(window(fresh, 1.7) != expected);  // so history matters here
        CHECK(window(copy, 2.1) == window(block, 2.1));
    }
}

TEST_CASE("acceleration: members in different iterations are found out without differences, too")
{
    AccelerationConfig const config = two_columns(Method::constant);
    Summaries summaries;
    for (int b = 0; b < 2; ++b) {
        AccelerationBlock block = block_of(config, b);
        block.begin_window(Ids{1});
        for (int k = 0; k <= b; ++k) summaries.push_back(block.summary({{0, 0}, {0}}, {{1, 0}, {1}}));
    }
    CHECK_NOTHROW(sluice::judge(config, Summaries{summaries[0], summaries[1]}));
    check_error(Exit::protocol, "block 1 in iteration 1", [&] {
        sluice::judge(config, Summaries{summaries[0], summaries[2]});
    });
}

TEST_CASE("acceleration: Aitken starts anew where its factor would be 0")
{
    AccelerationConfig const config{.method = Method::aitken, .columns = {{.name = "load.force"}}};
    AccelerationBlock block(config, 0, {{.joint = 0, .components = 2}});
    Columns next;
    block.begin_window(Ids{1});
    block.next(Summaries{block.summary({{0, 0}}, {{1, 0}})}, next);
    // the residual goes from (1, 0) to (1, 1): the change has nothing of the old one in it
    AccelerationStep const step = block.next(Summaries{block.summary({{0, 0}}, {{1, 1}})}, next);
    CHECK(step.relaxation == config.relaxation);
}

TEST_CASE("acceleration: what is below a column's floor has no say in the coefficients")
{
    AccelerationConfig config = two_columns();
    config.columns[1].floor = 1e-9;
    AccelerationBlock block = block_of(config);
    make_history(block, {1}, {{0, 0}, {0}}, {{1, 1}, {1e-15}});
    block.begin_window(Ids{1});
    Columns next;
    AccelerationStep const step = block.next(Summaries{block.summary({{0, 0}, {0}}, {{3, 1}, {-5e-15}})}, next);
    CHECK(step.coefficients[0] == close_to(-2).epsilon(1e-10));  // -(3 + 1) / (1 + 1)
}

TEST_CASE("acceleration: a saved state that is damaged or another edge's is refused")
{
    AccelerationConfig const config = two_columns();
    AccelerationBlock block = block_of(config);
    make_history(block, {1, 2}, {{1, 2, 3, 4}, {5, 6}}, {{1, 1, 1, 1}, {1, 1}});
    sluice::AccelerationState const good = block.save();
    AccelerationBlock other(config, 0, {{.joint = 1, .components = 1}, {.joint = 0, .components = 2}});
    auto refused = [&](AccelerationBlock& by, sluice::AccelerationState const& state) {
        check_error(Exit::io, "does not fit", [&] { by.restore(state); });
    };
    refused(other, good);
    AccelerationConfig const pair{.columns = {{.name = "a.x"}, {.name = "a.y"}}};
    AccelerationBlock xy(pair, 0, {{.joint = 0, .components = 1}, {.joint = 1, .components = 1}});
    AccelerationBlock yx(pair, 0, {{.joint = 1, .components = 1}, {.joint = 0, .components = 1}});
    refused(yx, xy.save());
    for (std::size_t length = 0; length < good.numbers.size(); ++length) {
        sluice::AccelerationState cut = good;
        cut.numbers.resize(length);
        refused(block, cut);
    }
    for (std::size_t length = 0; length < good.values.size(); ++length) {
        sluice::AccelerationState cut = good;
        cut.values.resize(length);
        refused(block, cut);
    }
    sluice::AccelerationState longer = good;
    longer.values.push_back(0);
    refused(block, longer);
    sluice::AccelerationState many = good;
    many.numbers[7] = std::numeric_limits<std::int64_t>::max();  // points
    refused(block, many);
    CHECK(block.save().values == good.values);  // a refusal changes nothing
}
