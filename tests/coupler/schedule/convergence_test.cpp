// How fast the accelerations of coupler/schedule find fixed points that are known.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/coupler/schedule/fixed_point.hpp"
#include "tests/support/close_to.hpp"

using fixed_point::distance;
using fixed_point::Group;
using fixed_point::Linear;
using fixed_point::linear_problem;
using fixed_point::norm;
using fixed_point::Outcome;
using fixed_point::Vector;
using sluice::AccelerationConfig;
using Method = AccelerationConfig::Method;

namespace {

AccelerationConfig config(Method method, double tolerance)
{
    return {.method = method, .columns = {{.name = "a.b", .tolerance = tolerance}}};
}

//! H' = -0.5 ... -10 on the diagonal and a little beside it: a fixed-point iteration has no chance.
Linear unstable(std::size_t n, std::mt19937& random)
{
    Vector diagonal(n);
    for (std::size_t i = 0; i < n; ++i) diagonal[i] = 0.5 + 9.5 * static_cast<double>(i + 1) / static_cast<double>(n);
    return linear_problem(diagonal, 0.3, random);
}

double relative_error(Vector const& x, Linear const& problem)
{
    return distance(x, problem.solution) / norm(problem.solution);
}

}  // namespace

TEST_CASE("acceleration: explicit and constant relaxation diverge where H' is large, IQN-ILS needs n + 1 evaluations")
{
    for (unsigned seed = 1; seed <= 5; ++seed)
        for (std::size_t const n : {1, 2, 3, 4, 5, 6}) {
            CAPTURE(seed);
            CAPTURE(n);
            std::mt19937 random(seed);
            Linear const problem = unstable(n, random);
            AccelerationConfig plain = config(Method::constant, 1e-10);
            for (double const relaxation : {1.0, 0.5}) {
                plain.relaxation = relaxation;
                Outcome const outcome = Group(plain, n, 1).window(problem, Vector(n, 0.0), 40);
                CHECK_FALSE(outcome.converged);
                CHECK(relative_error(outcome.x, problem) > 1e6);
            }
            // n differences span all there is, so that input n + 1 (counted from 0) is the solution up to rounding: the
            // condition of these V is below 1e4, so 1e4 * 1e-16 with two decades to spare
            Outcome const outcome =
                Group(config(Method::iqn_ils, 1e-10), n, 1).window(problem, Vector(n, 0.0), static_cast<int>(n) + 2);
            CHECK(outcome.converged);
            CHECK(outcome.inputs.size() == n + 2);
            CHECK(relative_error(outcome.x, problem) < 1e-10);
        }
}

TEST_CASE("acceleration: Aitken and IQN-ILS solve a linear equation in one unknown in three evaluations")
{
    for (double const slope : {-10.0, -2.0, -0.9, 0.5, 3.0})
        for (Method const method : {Method::aitken, Method::iqn_ils}) {
            CAPTURE(slope);
            Linear const problem{.rows = {{slope}}, .solution = {2.5}};
            Outcome const outcome = Group(config(method, 1e-12), 1, 1).window(problem, {1.0}, 3);
            CHECK(outcome.converged);  // relaxation, secant, confirmation
            CHECK(outcome.evaluations == 3);
            CHECK(outcome.x[0] == close_to(2.5).epsilon(1e-13));
        }
}

TEST_CASE("acceleration: Aitken's factor is that of Irons and Tuck over the joint vector")
{
    std::mt19937 random(3);
    Linear const problem = linear_problem({0.6, 1.4, 2.2, 3.0}, 0.2, random);
    AccelerationConfig aitken = config(Method::aitken, 1e-8);
    aitken.relaxation = 0.3;
    Outcome const outcome = Group(aitken, 4, 2).window(problem, Vector(4, 0.0), 100);
    CHECK(outcome.converged);
    CHECK(outcome.agreed);

    Vector x(4, 0.0), last;
    double factor = 0.3;
    for (Vector const& input : outcome.inputs) {
        // 1e-13 a step, and Aitken amplifies rounding while the residual is far from the end
        CHECK(distance(input, x) <= 1e-9 * norm(x));
        Vector const result = problem(x);
        Vector r(4), change(4);
        double up = 0, down = 0;
        for (std::size_t i = 0; i < 4; ++i) {
            r[i] = result[i] - x[i];
            if (last.empty()) continue;
            change[i] = r[i] - last[i];
            up += last[i] * change[i];
            down += change[i] * change[i];
        }
        if (!last.empty()) factor *= -up / down;
        for (std::size_t i = 0; i < 4; ++i) x[i] += factor * r[i];
        last = r;
    }
}

TEST_CASE("acceleration: one, two and three receivers take the same path, and all members the same step bit for bit")
{
    for (Method const method : {Method::constant, Method::aitken, Method::iqn_ils})
        for (std::size_t const n : {4, 30}) {
            std::mt19937 random(11);
            Vector diagonal(n);
            for (std::size_t i = 0; i < n; ++i) diagonal[i] = 0.1 + 2.4 * std::pow(0.7, static_cast<double>(i));
            Linear const problem = linear_problem(diagonal, 0.02, random);
            AccelerationConfig c = config(method, 1e-6);
            c.relaxation = 0.3;
            Outcome const whole = Group(c, n, 1).window(problem, Vector(n, 0.0), 100);
            CHECK(whole.converged);
            for (std::size_t const blocks : {2, 3}) {
                CAPTURE(n);
                CAPTURE(blocks);
                Outcome const split = Group(c, n, blocks).window(problem, Vector(n, 0.0), 100);
                CHECK(split.agreed);
                REQUIRE(split.inputs.size() == whole.inputs.size());
                // rounding of 1e-16, amplified by the condition of the differences (filter: at most 1e3 each)
                for (std::size_t k = 0; k < whole.inputs.size(); ++k)
                    CHECK(distance(split.inputs[k], whole.inputs[k]) <= 1e-9 * norm(problem.solution));
            }
        }
}

TEST_CASE("acceleration: a column's unit changes nothing, be it 1e-6 or 1e6 of another")
{
    // Powers of two, so that the path is the same to the last bit; the second half of the unknowns is the other column.
    std::mt19937 random(21);
    std::size_t const points = 3;
    Linear const problem = unstable(2 * points, random);
    double const micro = std::ldexp(1.0, -20), mega = std::ldexp(1.0, 20);
    auto scaled = [&](Vector x, double a, double b) {
        for (std::size_t i = 0; i < x.size(); ++i) x[i] *= i < points ? a : b;
        return x;
    };
    for (Method const method : {Method::aitken, Method::iqn_ils}) {
        AccelerationConfig const c{.method = method, .columns = {{.name = "load.force"}, {.name = "load.torque"}}};
        Outcome const plain = Group(c, points, 2).window(problem, Vector(2 * points, 0.0), 8);
        Outcome const units =
            Group(c, points, 2)
                .window([&](Vector const& x) { return scaled(problem(scaled(x, 1 / micro, 1 / mega)), micro, mega); },
                        Vector(2 * points, 0.0), 8);
        CHECK(plain.converged == (method == Method::iqn_ils));
        REQUIRE(units.inputs.size() == plain.inputs.size());
        for (std::size_t k = 0; k < plain.inputs.size(); ++k)
            CHECK(units.inputs[k] == scaled(plain.inputs[k], micro, mega));
    }
}

TEST_CASE("acceleration: nearly dependent differences are dropped, and what is left still converges")
{
    // H' has three different eigenvalues, so the differences of all windows lie in three directions. What is left of a
    // window near its end is rounding that lies anywhere, and the newest difference is never filtered: one more.
    std::size_t const n = 30;
    Linear problem{.rows = {}, .solution = Vector(n)};
    std::mt19937 random(31);
    Vector const direction = fixed_point::random_vector(n, random);
    for (std::size_t i = 0; i < n; ++i) {
        problem.rows.emplace_back(n, 0.0);
        problem.rows[i][i] = i % 3 == 0 ? -5.0 : i % 3 == 1 ? -2.0 : 0.3;
    }
    Group group(config(Method::iqn_ils, 1e-9), n, 2);
    for (int window = 0; window < 8; ++window) {
        CAPTURE(window);
        Vector start(n);
        for (std::size_t i = 0; i < n; ++i) {
            problem.solution[i] = 1 + 0.1 * window;
            start[i] = problem.solution[i] + direction[i] * std::cos(window);
        }
        Outcome const outcome = group.window(problem, start, 6);
        CHECK(outcome.converged);
        CHECK(outcome.agreed);
        CHECK(outcome.kept <= 4);
        // |r| <= 1e-9 |x~| and H' - 1 is at least 0.7
        CHECK(relative_error(outcome.x, problem) < 2e-9);
    }
}

TEST_CASE("acceleration: reuse over windows saves more than half of the evaluations of a slowly varying problem")
{
    std::size_t const n = 40;
    int const windows = 20;
    auto evaluations = [&](int history) {
        std::mt19937 random(5);
        Vector diagonal(n);
        for (std::size_t i = 0; i < n; ++i) diagonal[i] = 6 * std::exp(-0.3 * static_cast<double>(i));
        Linear const base = linear_problem(diagonal, 0.02, random);
        Linear const change = linear_problem(Vector(n, 0.0), 0.2, random);
        AccelerationConfig c = config(Method::iqn_ils, 1e-6);
        c.history = history;
        Group group(c, n, 2);
        Vector x(n, 0.0);
        int total = 0;
        for (int w = 0; w < windows; ++w) {
            Linear now = base;
            for (std::size_t i = 0; i < n; ++i) {
                now.solution[i] += change.solution[i] * std::sin(0.3 * w + static_cast<double>(i));
                for (std::size_t j = 0; j < n; ++j) now.rows[i][j] += 0.1 * std::sin(0.2 * w) * change.rows[i][j];
            }
            Outcome const outcome = group.window(now, x, 100);
            CHECK(outcome.converged);
            total += outcome.evaluations;
            x = outcome.x;
        }
        return total;
    };
    int const alone = evaluations(0), reused = evaluations(8);
    MESSAGE("evaluations in 20 windows: ", alone, " without reuse, ", reused, " with history 8");
    CHECK(reused * 2 < alone);
}
