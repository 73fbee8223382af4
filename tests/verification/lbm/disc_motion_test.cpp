#include <doctest/doctest.h>

#include <numbers>
#include <string>
#include <tuple>

#include "participants/lbm/solid_weight.hpp"
#include "tests/verification/lbm/lattice_case.hpp"

using namespace lattice_case;

namespace {

//! F/(mu U) of a disc dragged along the axis of a closed channel of width H and length 6 H [-].
double confined_drag(std::ptrdiff_t height, double ratio, double tau,
                     lbm::Precision precision = lbm::Precision::float64, lbm::Surface surface = lbm::Surface::covered)
{
    std::ptrdiff_t const length = 6 * height;
    lbm::Config c = config(length, height, tau);
    c.surface = surface;
    c.precision = precision;
    double const h = static_cast<double>(height), d = ratio * h;
    double const speed = 0.02 * c.viscosity / d;  // Re = 0.02
    lbm::Solver<2> solver(c);
    Discs discs;
    discs.add(0.5 * static_cast<double>(length), 0.5 * h, 0.5 * d, speed);
    double sum = 0;
    int const interval = static_cast<int>(h * h / c.viscosity / 30);
    auto const steps = [&] {
        sum = 0;
        for (int k = 0; k < interval; ++k) {
            solver.set_bodies(discs.view());
            solver.step();
            discs.position[0] += speed;
            sum -= solver.loads().force[0];
        }
        return sum / interval;
    };
    double x0 = 0, x1 = 0, x2 = steps(), limit = 0;
    for (int k = 0; k < 30; ++k) {  // the slowest mode decays exponentially: its limit from three means (Aitken)
        x0 = x1, x1 = x2, x2 = steps();
        if (k < 3) continue;
        double const next = x2 - (x2 - x1) * (x2 - x1) / ((x2 - x1) - (x1 - x0));
        bool const settled = std::abs(next - limit) < 3e-4 * std::abs(next);
        limit = next;
        if (settled) break;
    }
    return limit / (c.viscosity * speed);
}

//! All of a square but a disc in its middle.
lbm::Patch<2> around_a_hole(std::ptrdiff_t side, double radius)
{
    double const centre = 0.5 * static_cast<double>(side);
    sluice::Team team(1);
    lbm::Layout const layout({side, side, 1});
    lbm::Domain<2> const domain(layout, nullptr);
    lbm::Coverage<2> hole(domain, {});
    hole.update(std::vector<lbm::Body<2>>{{{centre, centre}, radius, {}}}, team);
    std::vector<double> wall(static_cast<std::size_t>(side * side), 1.0);
    for (lbm::Strip<2> const& s : hole.strips().first(hole.of_body(0)[1]))
        for (std::ptrdiff_t k = 0; k < s.count; ++k)
            wall[static_cast<std::size_t>(s.row * side + s.begin + k)] -= s.fraction(k);
    for (double& w : wall) w = w < 1e-12 ? 0 : w;
    return {.first = {0, 0, 0},
            .size = {side, side, 1},
            .fraction = wall,
            .centre = {centre, centre},
            .drag = lbm::flat_drag};
}

//! A disc turning in a circular cavity, both of area fractions.
struct Cavity
{
    double torque;     //!< T/(mu w R1^2) [-]
    double swirl_rms;  //!< of u_theta over the cells without solid, in w R1 [-]
};

Cavity turn_in_cavity(double inner, double outer, lbm::Surface surface)
{
    auto const side = static_cast<std::ptrdiff_t>(2 * outer + 4);
    lbm::Config c = config(side, side, 1.0);
    c.surface = surface;
    double const spin = 0.1 * c.viscosity / (inner * inner);  // Re = 0.1
    double const centre = 0.5 * static_cast<double>(side);
    lbm::Solver<2> solver(c, {around_a_hole(side, outer)});
    Discs discs;
    discs.add(centre, centre, inner, 0, 0, spin);
    solver.set_bodies(discs.view());
    auto const interval = static_cast<int>((outer - inner) * (outer - inner) / c.viscosity / 20);
    double const torque = run_to_steady(solver, interval, 1e-5, 100000, [&] { return -solver.loads().torque[0]; });
    lbm::Fields const f = solver.fields();
    double const b = spin * inner * inner * outer * outer / (outer * outer - inner * inner), a = -b / (outer * outer);
    double sum = 0, cells = 0;
    for (std::ptrdiff_t y = 0; y < side; ++y) {
        for (std::ptrdiff_t x = 0; x < side; ++x) {
            auto const k = static_cast<std::size_t>(y * side + x);
            if (f.solid_fraction[k] > 0) continue;
            double const rx = static_cast<double>(x) + 0.5 - centre, ry = static_cast<double>(y) + 0.5 - centre,
                         r = std::hypot(rx, ry);
            double const swirl = (rx * f.velocity[2 * k + 1] - ry * f.velocity[2 * k]) / r;
            double const error = (swirl - (a * r + b / r)) / (spin * inner);
            sum += error * error;
            cells += 1;
        }
    }
    return {torque / (c.viscosity * spin * inner * inner), std::sqrt(sum / cells)};
}

//! Added mass and damping, over rho pi a^2, of a disc that swings in the middle of a circular cavity.
struct Swing
{
    double mass, damping;
};

Swing swing_in_cavity(double radius, double ratio, double beta, lbm::Surface surface)
{
    auto const side = static_cast<std::ptrdiff_t>(2 * ratio * radius + 4);
    // slow beside sound, which takes 6 R/c_s = 10 R steps to and fro: errors go with (w R/c_s)^2, here 0.016 at R = 48
    double const period = 4200, w = 2 * std::numbers::pi / period, viscosity = w * radius * radius / beta;
    lbm::Config c = config(side, side, 0.5 + 3 * viscosity);
    c.surface = surface;
    double const centre = 0.5 * static_cast<double>(side), amplitude = 0.02 * radius;
    lbm::Solver<2> solver(c, {around_a_hole(side, ratio * radius)});
    double in_phase = 0, out_of_phase = 0;
    for (int k = 0; k < static_cast<int>(6 * period); ++k) {
        double const t = k + 0.5;  // velocities are those of the middle of a step
        Discs discs;
        discs.add(centre + amplitude * std::sin(w * k), centre, radius, amplitude * w * std::cos(w * t));
        solver.set_bodies(discs.view());
        solver.step();
        if (k < static_cast<int>(3 * period)) continue;
        double const force = solver.loads().force[0] / (1.5 * period);
        in_phase -= force * std::sin(w * t);
        out_of_phase -= force * std::cos(w * t);
    }
    double const unit = std::numbers::pi * radius * radius * amplitude * w * w;  // F = -unit (Cv cos - Cm sin)
    return {-in_phase / unit, out_of_phase / unit};
}

//! w/rate of a neutral disc that is free to turn, in the middle between walls H apart that move against each other; H
//! in cells, ratio = 2 a/H.
double turning_in_shear(std::ptrdiff_t height, double ratio, lbm::Surface surface)
{
    std::ptrdiff_t const length = 4 * height;
    lbm::Config c = config(length, height, 1.5);
    c.surface = surface;
    c.set_periodic(0);
    double const h = static_cast<double>(height), a = 0.5 * ratio * h, rate = 0.02 * c.viscosity / (a * a);
    c.walls[lbm::bottom<2>].velocity[0] = -0.5 * rate * h;
    c.walls[lbm::top<2>].velocity[0] = 0.5 * rate * h;
    lbm::Solver<2> solver(c);
    solver.set_state([&](std::array<double, 2> const& at) {
        return lbm::PointState<2>{
            .velocity = {rate * (at[1] - 0.5 * h), 0}, .pressure = 0, .gradient = {{{0, rate}, {0, 0}}}};
    });
    double spin = -0.5 * rate;
    double const inertia = 0.5 * std::numbers::pi * a * a * a * a;
    auto const interval = static_cast<int>(h * h / c.viscosity / 40);
    double before = 0;
    for (int k = 0; k < 60; ++k) {
        for (int step = 0; step < interval; ++step) {
            Discs discs;
            discs.add(0.5 * static_cast<double>(length), 0.5 * h, a, 0, 0, spin);
            solver.set_bodies(discs.view());
            solver.step();
            spin += solver.loads().torque[0] / inertia;
        }
        if (k > 4 && std::abs(spin - before) < 1e-5 * rate) break;
        before = spin;
    }
    return spin / rate;
}

//! U/U_max of a neutral disc that is free to move along the middle of a channel H wide; H in cells, ratio = 2 a/H.
//! U_max is that of the parabola with the same flux: what flows through every cross-section.
double carried_in_channel(std::ptrdiff_t height, double ratio, lbm::Surface surface)
{
    std::ptrdiff_t const length = 8 * height;
    lbm::Config c = config(length, height, 1.5);
    c.surface = surface;
    c.set_periodic(0);
    double const h = static_cast<double>(height), a = 0.5 * ratio * h, fastest = 0.02 * c.viscosity / a;
    c.acceleration = {8 * c.viscosity * fastest / (h * h), 0, 0};  // on the disc, too, as a pressure gradient would
    lbm::Solver<2> solver(c);
    solver.set_state([&](std::array<double, 2> const& at) {
        double const y = at[1] / h;
        return lbm::PointState<2>{.velocity = {4 * fastest * y * (1 - y), 0},
                                  .pressure = 0,
                                  .gradient = {{{0, 4 * fastest * (1 - 2 * y) / h}, {0, 0}}}};
    });
    double const mass = std::numbers::pi * a * a;
    double x = 0.5 * static_cast<double>(length), u = fastest, before = 0;
    auto const interval = static_cast<int>(h * h / c.viscosity / 40);
    auto const share = [&] { return u / (1.5 * mean_velocity(solver, 0)); };
    for (int k = 0; k < 60; ++k) {
        for (int step = 0; step < interval; ++step) {
            Discs discs;
            discs.add(x, 0.5 * h, a, u);
            solver.set_bodies(discs.view());
            solver.step();
            u += solver.loads().force[0] / mass + c.acceleration[0];
            x += u;
        }
        double const now = share();
        if (k > 4 && std::abs(now - before) < 1e-5) break;
        before = now;
    }
    return share();
}

}  // namespace

namespace {

//! Reference: fundamental solutions, 7 digits; Faxen's series agrees to 5 digits for k <= 0.2.
void check_dragged(std::ptrdiff_t height, double ratio, double tau, double reference, double mark)
{
    verification::Stopwatch const watch;
    double const got = confined_drag(height, ratio, tau);
    CHECK(verification::report({"C03",
                                text("F/(mu U) at k=%.1f, d=%.1f dx [-]", ratio, ratio * static_cast<double>(height)),
                                got, reference, relative(got, reference), mark, watch.seconds()}));
}

}  // namespace

TEST_CASE("C03: disc dragged along the axis of a closed channel")
{
    check_dragged(80, 0.2, 1.0, 16.532547, 0.03);
    check_dragged(54, 0.3, 1.0, 29.15854, 0.03);
    check_dragged(32, 0.5, 1.0, 99.367607, 0.03);
}

TEST_CASE("C03: the same, d = 32 cells" * doctest::skip())
{
    check_dragged(107, 0.3, 1.0, 29.15854, 0.015);
    check_dragged(160, 0.2, 1.5, 16.532547, 0.015);
}

TEST_CASE("C03: the same in a wide channel" * doctest::skip())
{
    check_dragged(160, 0.1, 1.5, 8.950604, 0.03);
}

TEST_CASE("C03: the same in single precision")
{
    verification::Stopwatch const watch;
    double const got = confined_drag(54, 0.3, 1.0, lbm::Precision::float32), reference = 29.15854;
    CHECK(verification::report({"C03", text("single precision, F/(mu U) at k=%.1f, d=%.1f dx [-]", 0.3, 16.2), got,
                                reference, relative(got, reference), 0.03, watch.seconds()}));
}

TEST_CASE("C03: the same with an interpolated surface, and with direct forcing")
{
    for (auto const surface : {lbm::Surface::interpolated, lbm::Surface::forced}) {
        verification::Stopwatch const watch;
        double const got = confined_drag(54, 0.3, 1.0, lbm::Precision::float64, surface), reference = 29.15854;
        CHECK(verification::report({"C03", of_surface(surface, text("F/(mu U) at k=%.1f, d=%.1f dx [-]", 0.3, 16.2)),
                                    got, reference, relative(got, reference), 0.03, watch.seconds()}));
    }
}

namespace {

//! Closed form: T = 4 pi mu w R1^2 R2^2/(R2^2 - R1^2).
void check_cavity(char const* name, double inner, double outer, double mark, lbm::Surface surface)
{
    verification::Stopwatch const watch;
    Cavity const got = turn_in_cavity(inner, outer, surface);
    double const ratio = inner / outer, reference = 4 * std::numbers::pi / (1 - ratio * ratio);
    std::string const at = text(" at R1=%.0f, R2=%.0f dx [-]", inner, outer);
    CHECK(verification::report({name, of_surface(surface, "T/(mu w R1^2)" + at), got.torque, reference,
                                relative(got.torque, reference), mark, watch.seconds()}));
    CHECK(verification::report({name, of_surface(surface, "u_theta RMS / (w R1)" + at), got.swirl_rms, 0, got.swirl_rms,
                                mark, watch.seconds()}));
}

}  // namespace

TEST_CASE("C04: disc turning in a circular cavity")
{
    // marks 3 % at R1 = 10 cells, 1.5 % at 20
    for (auto const surface : all_surfaces) {
        check_cavity("C04", 10, 30, 0.03, surface);
        check_cavity("C04", 20, 60, 0.015, surface);
    }
}

TEST_CASE("C04b: disc turning in a narrow and in a wide cavity")
{
    check_cavity("C04b", 12, 24, 0.03, lbm::Surface::covered);
    check_cavity("C04b", 16, 80, 0.03, lbm::Surface::covered);
}

namespace {

//! What a free disc does between walls; fundamental solutions, mark 1.5 % with a of 12 cells or more.
void check_free(char const* what, double (*measure)(std::ptrdiff_t, double, lbm::Surface), std::ptrdiff_t height,
                double ratio, double reference, lbm::Surface surface)
{
    verification::Stopwatch const watch;
    double const got = measure(height, ratio, surface);
    std::string const name =
        of_surface(surface, what + text(" at 2a/H=%.1f, H=%.0f dx [-]", ratio, static_cast<double>(height)));
    CHECK(verification::report({"C05b", name, got, reference, relative(got, reference), 0.015, watch.seconds()}));
}

}  // namespace

TEST_CASE("C05b: a free disc turns with a shear between walls")
{
    for (auto const surface : all_surfaces) {
        check_free("w/rate", turning_in_shear, 48, 0.5, -0.419573, surface);
        check_free("w/rate", turning_in_shear, 120, 0.2, -0.488717, surface);
    }
}

TEST_CASE("C05b: a free disc is carried along the middle of a channel")
{
    for (auto const surface : all_surfaces) check_free("U/U_max", carried_in_channel, 48, 0.5, 0.887999, surface);
}

//! Two minutes.
TEST_CASE("C05b: the same in wide channels" * doctest::skip())
{
    check_free("w/rate", turning_in_shear, 240, 0.1, -0.497243, lbm::Surface::covered);
    check_free("U/U_max", carried_in_channel, 120, 0.2, 0.980323, lbm::Surface::covered);
    check_free("U/U_max", carried_in_channel, 240, 0.1, 0.995020, lbm::Surface::covered);
}

TEST_CASE("C06: added mass and damping of a disc that swings in a cavity, a = 16 cells")
{
    struct Row
    {
        double ratio, beta, mass, damping;
    };
    // unsteady Stokes flow in closed form (Bessel functions); mark 4 % with a of 16 cells, with direct forcing also
    // what half a cell of a makes, in its square
    auto const check = [](Row const& row, lbm::Surface surface) {
        double const mark = surface == lbm::Surface::forced ? 0.04 + 2 * 0.5 / 16 : 0.04;
        verification::Stopwatch const watch;
        Swing const got = swing_in_cavity(16, row.ratio, row.beta, surface);
        std::string const at = text(" at R/a=%.0f, beta=%.0f [-]", row.ratio, row.beta);
        CHECK(verification::report({"C06", of_surface(surface, "C_m" + at), got.mass, row.mass,
                                    relative(got.mass, row.mass), mark, watch.seconds()}));
        CHECK(verification::report({"C06", of_surface(surface, "C_v" + at), got.damping, row.damping,
                                    relative(got.damping, row.damping), mark, watch.seconds()}));
    };
    Row const rows[] = {
        {2, 20, 2.516751271, 2.304002269}, {3, 10, 2.278266967, 1.714060263}, {3, 40, 1.825542519, 0.7142255367}};
    for (Row const& row : rows) check(row, lbm::Surface::covered);
    for (auto const surface : {lbm::Surface::interpolated, lbm::Surface::forced}) check(rows[0], surface);
}

namespace {

constexpr double rest_radius = 8;

//! Fluid at rest under gravity in a box that is periodic in x, 12 radii wide and 8 high.
lbm::Config pool(double gravity)
{
    lbm::Config c = config(96, 64, 1.0);
    make_periodic(c, true, false);
    c.acceleration = {0, -gravity};
    return c;
}

void fill(lbm::Solver<2>& solver, double gravity)
{
    solver.set_state([&](std::array<double, 2> const& at) {
        double const y = at[1];
        return lbm::PointState<2>{.velocity = {}, .pressure = gravity * (32 - y), .gradient = {}};
    });
}

}  // namespace

TEST_CASE("C07: buoyancy of a disc at rest on the floor, ten places within a cell")
{
    // closed form rho_f g V; with area fractions 0.5 % in the mean and 0.5 % in the scatter
    verification::Stopwatch const watch;
    double const gravity = 1e-6, reference = std::numbers::pi * rest_radius * rest_radius * gravity;
    for (auto const surface : all_surfaces) {
        double mean = 0, scatter = 0;
        for (int k = 0; k < 10; ++k) {
            lbm::Config c = pool(gravity);
            c.surface = surface;
            lbm::Solver<2> solver(c);
            fill(solver, gravity);
            Discs discs;
            discs.add(48 + std::fmod(0.618 * k, 1.0), rest_radius + 0.1 * k, rest_radius);
            solver.set_bodies(discs.view());
            double sum = 0;
            for (int step = 0; step < 6000; ++step) {
                solver.step();
                if (step >= 5000) sum += solver.loads().force[1] / 1000;
            }
            mean += sum / 10;
            scatter = std::max(scatter, relative(sum, reference));
        }
        CHECK(verification::report({"C07", of_surface(surface, "mean buoyancy / (rho_f g V) [-]"), mean / reference, 1,
                                    relative(mean, reference), 0.005, watch.seconds()}));
        CHECK(verification::report({"C07", of_surface(surface, "largest deviation of ten offsets [-]"), scatter, 0,
                                    scatter, 0.005, watch.seconds()}));
    }
}

TEST_CASE("C07: a neutrally buoyant disc in fluid at rest stays where it is")
{
    verification::Stopwatch const watch;
    double const gravity = 1e-6, mass = std::numbers::pi * rest_radius * rest_radius;
    lbm::Solver<2> solver(pool(gravity));
    fill(solver, gravity);
    Discs discs;
    discs.add(48.3, 30.6, rest_radius);
    double drift = 0;
    auto const steps = static_cast<int>(10 * rest_radius * rest_radius / solver.config().viscosity);
    for (int step = 0; step < steps; ++step) {
        solver.set_bodies(discs.view());
        solver.step();
        for (std::size_t k : {0UL, 1UL}) {
            discs.velocity[k] += solver.loads().force[k] / mass - (k == 1 ? gravity : 0);
            discs.position[k] += discs.velocity[k];
        }
        discs.spin[0] += solver.loads().torque[0] / (0.5 * mass * rest_radius * rest_radius);
        drift = std::hypot(discs.position[0] - 48.3, discs.position[1] - 30.6);
    }
    CHECK(verification::report({"C07", "drift / a after nu t/a^2 = 10, rho_s = rho_f [-]", drift / rest_radius, 0,
                                drift / rest_radius, 1e-3, watch.seconds()}));
}
