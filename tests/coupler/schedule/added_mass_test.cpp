// C09c: a body in a fluid whose reaction is its added mass, rho_s V a = F - C_A rho_f V a. Exchanged one window late
// (explicit staggering) the error is multiplied by -m, m = C_A rho_f / rho_s, in every window, whatever its length:
// stable only for m < 1. Repeated inside a window, the same map a~ = F / (rho_s V) - m a is what the accelerations
// solve. Source: closed form; table C09c_added_mass_stability.csv of the catalogue, quoted below.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/coupler/schedule/fixed_point.hpp"
#include "tests/support/close_to.hpp"

using fixed_point::Group;
using fixed_point::Outcome;
using fixed_point::Vector;
using sluice::AccelerationConfig;
using Method = AccelerationConfig::Method;

namespace {

struct Row
{
    double density_ratio;         //!< rho_s / rho_f
    double disc, sphere;          //!< error ratio of a window
    double most_relaxation_disc;  //!< constant relaxation is stable below it
};

constexpr Row table[] = {{2.65, -0.3773584906, -0.1886792453, 1.452054795},
                         {1.5, -2.0 / 3, -1.0 / 3, 1.2},
                         {1.1, -0.9090909091, -0.4545454545, 1.047619048},
                         {1.001, -0.999000999, -0.4995004995, 1.00049975},
                         {0.9, -1.111111111, -0.5555555556, 0.9473684211},
                         {0.5, -2, -1, 0.6666666667},
                         {0.1, -10, -5, 0.1818181818}};

//! rho_f V = 1; the force of window n, and the acceleration that belongs to it.
struct Body
{
    double density_ratio, added_mass;
    double ratio() const { return added_mass / density_ratio; }
    double force(int window) const { return 1 + 0.2 * std::sin(0.5 * window); }
    double exact(int window) const { return force(window) / (density_ratio + added_mass); }
    Vector operator()(Vector const& a, int window) const
    {
        return {(force(window) - added_mass * a[0]) / density_ratio};
    }
};

Outcome first_window(Body const& body, AccelerationConfig const& config, int most)
{
    return Group(config, 1, 1).window([&](Vector const& a) { return body(a, 0); }, {0.0}, most);
}

}  // namespace

TEST_CASE("C09c: explicit staggering multiplies the error by the table's ratio in every window")
{
    for (Row const& row : table)
        for (bool const disc : {true, false}) {
            Body const body{row.density_ratio, disc ? 1.0 : 0.5};
            double const expected = disc ? row.disc : row.sphere;
            CAPTURE(row.density_ratio);
            CHECK(-body.ratio() == close_to(expected).epsilon(1e-9));  // the table has ten digits
            Vector a = {0.0};
            double const start = std::abs(a[0] - body.exact(0));
            for (int n = 0; n < 40; ++n) {
                double const before = a[0] - body.exact(0);
                a = body(a, 0);
                if (std::abs(before) > 1e-6 * start)  // above rounding
                    CHECK((a[0] - body.exact(0)) / before == close_to(expected).epsilon(1e-6));
            }
            double const end = std::abs(a[0] - body.exact(0));
            if (expected > -1) CHECK(end < start);
            if (expected < -1) CHECK(end > 60 * start);  // 1.111^40 = 67.7
        }
}

TEST_CASE(
    "C09c: constant relaxation is stable up to the table's limit and takes the closed form's number of evaluations")
{
    for (Row const& row : table) {
        CAPTURE(row.density_ratio);
        Body const body{row.density_ratio, 1.0};
        double const m = body.ratio(), tolerance = 1e-8;
        AccelerationConfig config{.method = Method::constant,
                                  .columns = {{.name = "load.force", .tolerance = tolerance}}};
        for (double const share : {0.3, 0.9}) {
            config.relaxation = share * row.most_relaxation_disc;
            // e_k = g^k e_0, g = 1 - omega (1 + m); r_k = -(1 + m) e_k; x~_k = x* - m e_k
            double const g = 1 - config.relaxation * (1 + m), exact = body.exact(0);
            int expected = 1;
            for (double e = -exact; (1 + m) * std::abs(e) > tolerance * std::abs(exact - m * e); e *= g) ++expected;
            Outcome const outcome = first_window(body, config, 1000);
            CHECK(outcome.converged);
            CHECK(outcome.evaluations == expected);
        }
        config.relaxation = 1.05 * row.most_relaxation_disc;
        Outcome const outcome = first_window(body, config, 1000);
        CHECK_FALSE(outcome.converged);
        CHECK(std::abs(outcome.x[0]) > 1e6);  // |g| = 1.1: 1.1^999
    }
}

TEST_CASE("C09c: with Aitken or IQN-ILS a window takes three evaluations down to a density ratio of 0.1")
{
    for (Method const method : {Method::aitken, Method::iqn_ils})
        for (Row const& row : table)
            for (double const added_mass : {1.0, 0.5}) {
                CAPTURE(row.density_ratio);
                Body const body{row.density_ratio, added_mass};
                AccelerationConfig const config{.method = method,
                                                .columns = {{.name = "load.force", .tolerance = 1e-10}}};
                Outcome const outcome = first_window(body, config, 3);
                CHECK(outcome.converged);
                CHECK(outcome.evaluations <= 3);  // relaxation may hit the solution: disc of ratio 1, C_A 1
                CHECK(outcome.x[0] == close_to(body.exact(0)).epsilon(1e-10));
            }
}

TEST_CASE(
    "C09c: through 40 windows of a light body the implicit solution is exact, and history saves an evaluation each")
{
    Body const body{0.1, 1.0};
    AccelerationConfig const config{.columns = {{.name = "load.force", .tolerance = 1e-10}}};
    Group group(config, 1, 1);
    Vector implicit = {0.0}, late = {0.0};
    int evaluations = 0;
    for (int n = 0; n < 40; ++n) {
        Outcome const outcome = group.window([&](Vector const& a) { return body(a, n); }, implicit, 10);
        CHECK(outcome.converged);
        implicit = outcome.x;
        CHECK(implicit[0] == close_to(body.exact(n)).epsilon(1e-9));
        evaluations += outcome.evaluations;
        late = body(late, n);
    }
    CHECK(evaluations == 3 + 39 * 2);
    CHECK(std::abs(late[0]) > 1e30);  // 10^40
}

TEST_CASE("C09c: bodies of all the table's densities that feel each other's flow converge in n + 3 evaluations")
{
    // Added mass 1 of its own and up to 5 % of the others' (Lamb, Hydrodynamics, art. 138: falls with distance squared)
    std::size_t const n = std::size(table);
    std::mt19937 random(2);
    Vector const far = fixed_point::random_vector(n * n, random);
    auto map = [&](Vector const& a) {
        Vector result(n);
        for (std::size_t i = 0; i < n; ++i) {
            double reaction = a[i];
            for (std::size_t j = 0; j < n; ++j)
                if (j != i) reaction += 0.05 * far[std::min(i, j) * n + std::max(i, j)] * a[j];
            result[i] = (1 - reaction) / table[i].density_ratio;
        }
        return result;
    };
    AccelerationConfig config{.columns = {{.name = "load.force", .tolerance = 1e-8}}};
    for (std::size_t const blocks : {1, 3}) {
        Outcome const outcome = Group(config, n, blocks).window(map, Vector(n, 0.0), 50);
        CHECK(outcome.converged);
        CHECK(outcome.agreed);
        // n + 2 if every difference counted; the filter drops one that is 99.9 % known
        CHECK(outcome.evaluations <= static_cast<int>(n) + 3);
    }
    config.method = Method::constant;
    config.relaxation = 1;
    CHECK_FALSE(Group(config, n, 1).window(map, Vector(n, 0.0), 50).converged);
}
