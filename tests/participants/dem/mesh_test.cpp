#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "coupler/base/error.hpp"
#include "participants/dem/measures.hpp"
#include "participants/dem/random.hpp"
#include "tests/participants/dem/mesh_scenes.hpp"
#include "tests/support/close_to.hpp"

using namespace unit;

namespace {

std::size_t contacts_of(dem::Solver<3> const& solver)
{
    return dem::contact_numbers(solver.setup(), solver.state()).contacts;
}

//! A sphere that falls obliquely with spin, bounces, slides and then rolls on the floor z = 0.
dem::Solver<3> thrown(dem::Shape<3> floor, dem::Setup<3> s, Axes const& axes)
{
    add_wall(s, std::move(floor));
    return {s, sphere(axes(-0.021, -0.017, 0.006), axes(0.31, 0.22, -0.1), axes(20.0, -35.0, 15.0))};
}

}  // namespace

TEST_CASE("mesh: on a floor of triangles a sphere moves as on a plane")
{
    for (bool const is_turned : {false, true})
        for (auto const rolling : {dem::Rolling::none, dem::Rolling::elastic_plastic, dem::Rolling::constant})
            for (int const cells : {1, 7, 40}) {  // triangles of 10, 1.5 and 0.25 radii
                Axes const axes = is_turned ? turned() : Axes{};
                dem::Setup<3> const s = sphere_setup(sphere_contact(0.4, rolling), axes);
                auto plane = thrown(dem::Plane<3>{{}, axes.z}, s, axes);
                auto mesh = thrown(mesh_of(flat(cells, 0.05, axes)), s, axes);
                int touching = 0;
                double apart = 0.0, turning = 0.0;
                for (int n = 0; n < 8000; ++n) {
                    plane.step(sphere_step), mesh.step(sphere_step);
                    touching += contacts_of(mesh) > 0;
                    REQUIRE(contacts_of(mesh) == contacts_of(plane));
                    apart = std::max(apart, norm(mesh.grains().place[0].centre - plane.grains().place[0].centre));
                    turning = std::max(turning, norm(mesh.grains().motion[0].spin - plane.grains().motion[0].spin));
                }
                CHECK(touching > 2000);
                CHECK(norm(plane.grains().place[0].centre - axes(-0.021, -0.017, 0.005)) > 0.02);  // over many edges
                // A place of 0.03 m is kept to 7e-18 m, 1.4e-15 R: some hundred roundings in 8000 steps that go either
                // way; a spin of 50 rad/s follows from forces that are as much off, over an overlap of 1e-6 m.
                CHECK(apart < 1e-12 * sphere_radius);
                CHECK(turning < 1e-10 * 50.0);
            }
}

TEST_CASE("mesh: facets that lie on one another, and corners on other facets' edges, are felt once")
{
    Axes const axes = turned();
    dem::Setup<3> const s = sphere_setup(sphere_contact(0.4, dem::Rolling::elastic_plastic), axes);
    Triangles twice = flat(7, 0.05, axes);
    for (auto const& corner : flat(10, 0.05, axes)) twice.push_back(corner);
    auto plane = thrown(dem::Plane<3>{{}, axes.z}, s, axes), mesh = thrown(mesh_of(twice), s, axes);
    for (int n = 0; n < 8000; ++n) {
        plane.step(sphere_step), mesh.step(sphere_step);
        REQUIRE(contacts_of(mesh) == contacts_of(plane));
    }
    CHECK(norm(mesh.grains().place[0].centre - plane.grains().place[0].centre) < 1e-12 * sphere_radius);  // as above
}

TEST_CASE("mesh: friction goes along where a sphere leaves a facet, and all overlap with it, within one step")
{
    // In a thousandth of the weight the patch of contact is 4 um wide, a step 15 um; the sphere rolls, so that the
    // spring that slows it is not at its limit.
    dem::Setup<3> s = sphere_setup(sphere_contact(0.4, dem::Rolling::elastic_plastic));
    s.gravity = {0, 0, -0.01};
    double const overlap = 0.01 * density * dem::volume_of<3>(sphere_radius) / sphere_stiffness;
    auto const rolled = [&](dem::Shape<3> floor) {
        dem::Setup<3> on = s;
        add_wall(on, std::move(floor));
        return dem::Solver<3>(on, sphere({-0.021, 0.003, sphere_radius - overlap}, {1, 0, 0}, {0, 200, 0}));
    };
    auto plane = rolled(dem::Plane<3>{{}, {0, 0, 1}}), mesh = rolled(mesh_of(flat(40, 0.05)));
    for (int n = 0; n < 3000; ++n) plane.step(sphere_step), mesh.step(sphere_step);
    CHECK(mesh.grains().place[0].centre.x > 0.02);
    CHECK(plane.grains().motion[0].velocity.x < 1.0);
    CHECK(norm(mesh.grains().place[0].centre - plane.grains().place[0].centre) < 1e-12 * sphere_radius);
    CHECK(norm(mesh.grains().motion[0].spin - plane.grains().motion[0].spin) < 1e-10 * 200.0);
}

TEST_CASE("mesh: on a floor of triangles the ledger is that of a plane, entry by entry")
{
    for (auto const elasticity : {dem::Elasticity::linear, dem::Elasticity::hertz}) {
        dem::ContactConfig c = sphere_contact(0.4, dem::Rolling::elastic_plastic);
        c.elasticity = elasticity;
        c.youngs_modulus = 1e7, c.poissons_ratio = 0.25;
        Axes const axes = turned();
        dem::Setup<3> s = sphere_setup(c, axes);
        s.features.ledger = true;
        auto plane = thrown(dem::Plane<3>{{}, axes.z}, s, axes);
        auto mesh = thrown(mesh_of(flat(40, 0.05, axes)), s, axes);
        double const start = mesh.energies().balance(), scale = mesh.energies().kinetic();
        for (int n = 0; n < 8000; ++n) plane.step(sphere_step), mesh.step(sphere_step);
        auto const a = plane.energies(), b = mesh.energies();
        CHECK(a.sliding > 0.01 * scale);
        CHECK(a.rolling > 0.001 * scale);
        for (auto const entry :
             {&dem::Energies::touch, &dem::Energies::sliding, &dem::Energies::rolling, &dem::Energies::normal_dashpot,
              &dem::Energies::tangential_dashpot, &dem::Energies::elastic_normal, &dem::Energies::elastic_tangential})
            CHECK(std::abs(a.*entry - b.*entry) < 1e-9 * scale);
        CHECK(std::abs(b.balance() - start) < 1e-4 * scale);  // the mark of the ledger, as on planes
    }
}

TEST_CASE("mesh: LIGGGHTS' order and a floor whose corners are rounded")
{
    SUBCASE("as on a plane")
    {
        dem::Setup<3> s = sphere_setup(sphere_contact(0.4, dem::Rolling::constant));
        s.features.scheme = dem::Scheme::liggghts;
        auto plane = thrown(dem::Plane<3>{{}, {0, 0, 1}}, s, {}), mesh = thrown(mesh_of(flat(40, 0.05)), s, {});
        for (int n = 0; n < 8000; ++n) plane.step(sphere_step), mesh.step(sphere_step);
        CHECK(norm(mesh.grains().place[0].centre - plane.grains().place[0].centre) < 1e-11 * sphere_radius);
    }
    SUBCASE("to single precision of a metre, 6e-8 m: one contact all the same, and a path as much off")
    {
        dem::Random random(3);
        auto const rough = sheet(20, 0.05, {}, [&](double, double) { return random.uniform(-6e-8, 6e-8); });
        dem::Setup<3> const s = sphere_setup(sphere_contact(0.4, dem::Rolling::elastic_plastic));
        auto plane = thrown(dem::Plane<3>{{}, {0, 0, 1}}, s, {}), mesh = thrown(mesh_of(rough), s, {});
        std::size_t most = 0;
        for (int n = 0; n < 8000; ++n) {
            plane.step(sphere_step), mesh.step(sphere_step);
            most = std::max(most, contacts_of(mesh));
        }
        CHECK(most == 1);
        // Slopes of up to 2 x 6e-8 m / 5 mm along x and y turn what the floor gives by 3.4e-5: per mass, the weight
        // over T = 0.12 s and the first fall, 0.25 m/s, with friction 1.4 times that.
        double const time = 8000 * sphere_step, slope = std::sqrt(2.0) * 1.2e-7 / 5e-3;
        CHECK(norm(mesh.grains().place[0].centre - plane.grains().place[0].centre) <
              1.4 * (9.81 * time + 0.25) * slope * time);
    }
}

TEST_CASE("mesh: a sphere at rest on a face, a ridge, a peak, in a groove and in a corner")
{
    double const pi = std::numbers::pi, far = 0.03, weight = density * dem::volume_of<3>(sphere_radius) * 9.81;
    double const slope = 35.0 * pi / 180.0, drop = far * std::tan(slope);
    dem::Setup<3> s = sphere_setup(sphere_contact(0.0));
    auto const rests = [&](Triangles const& triangles, Vec3 at, std::size_t contacts, double force) {
        dem::Setup<3> on = s;
        add_wall(on, mesh_of(triangles));
        dem::Solver<3> solver(on, sphere(at));
        settle(solver, 12000, 0.3);  // exp(-0.3 x 2700/s x 0.1 s) is nothing
        CHECK(contacts_of(solver) == contacts);
        CHECK(dem::contact_numbers(solver.setup(), solver.state()).largest_overlap * 2.0 * sphere_radius ==
              close_to(force / sphere_stiffness).epsilon(1e-9));
        CHECK(solver.state().walls[0].force.z == close_to(weight).epsilon(1e-9));
        return solver.grains().place[0].centre;
    };
    double const over = sphere_radius - weight / sphere_stiffness;  // of the centre over what it stands on
    SUBCASE("ridge along y")
    {
        Triangles roof;
        add_quad(roof, {0, -far, 0}, {0, far, 0}, {far, far, -drop}, {far, -far, -drop});
        add_quad(roof, {0, -far, 0}, {0, far, 0}, {-far, far, -drop}, {-far, -far, -drop});
        Vec3 const at = rests(roof, {0, 0, 1.01 * sphere_radius}, 1, weight);
        CHECK(at.z == close_to(over).epsilon(1e-9));
        CHECK(at.x == 0.0);
    }
    SUBCASE("peak of a pyramid")
    {
        Triangles pyramid;
        std::array<Vec3, 4> const foot{Vec3{far, 0, -drop}, {0, far, -drop}, {-far, 0, -drop}, {0, -far, -drop}};
        for (std::size_t k = 0; k < 4; ++k) pyramid.push_back({Vec3{}, foot[k], foot[(k + 1) % 4]});
        CHECK(rests(pyramid, {0, 0, 1.01 * sphere_radius}, 1, weight).z == close_to(over).epsilon(1e-9));
    }
    SUBCASE("groove: N = m g / (2 cos) on each side, the centre (R - N/k) / cos over its bottom")
    {
        Triangles groove;
        add_quad(groove, {0, -far, 0}, {0, far, 0}, {far, far, drop}, {far, -far, drop});
        add_quad(groove, {0, -far, 0}, {0, far, 0}, {-far, far, drop}, {-far, -far, drop});
        double const force = 0.5 * weight / std::cos(slope);
        Vec3 const at = rests(groove, {1e-4, 0, 1.3 * sphere_radius}, 2, force);
        CHECK(at.z == close_to((sphere_radius - force / sphere_stiffness) / std::cos(slope)).epsilon(1e-9));
        CHECK(std::abs(at.x) < 1e-9 * sphere_radius);
    }
    SUBCASE("corner of three faces that stand on one another, its diagonal upright: N = m g / sqrt(3)")
    {
        // edges along a, b, c from the origin, each up by 1/sqrt(3)
        Vec3 const a{std::sqrt(2.0 / 3.0), 0, std::sqrt(1.0 / 3.0)};
        auto const turn = [&](double angle) { return Vec3{a.x * std::cos(angle), a.x * std::sin(angle), a.z}; };
        Vec3 const b = turn(2.0 * pi / 3.0), c = turn(4.0 * pi / 3.0);
        Triangles corner;
        for (auto const& [u, v] : {std::pair{a, b}, {b, c}, {c, a}})
            add_quad(corner, {}, far * u, far * (u + v), far * v);
        double const force = weight / std::sqrt(3.0);
        Vec3 const at = rests(corner, {1e-5, 2e-5, 1.8 * sphere_radius}, 3, force);
        CHECK(at.z == close_to(std::sqrt(3.0) * (sphere_radius - force / sphere_stiffness)).epsilon(1e-9));
    }
}

TEST_CASE("mesh: a sphere rolls over a concave edge as one contact or two, and the ledger books the change of facet")
{
    double const weight = density * dem::volume_of<3>(sphere_radius) * 9.81, half = 0.05;
    for (double const angle : {0.005, 0.02, 0.05, 0.2}) {  // the cap of a sphere at rest: 0.023
        Triangles floor;
        Vec3 const up{half * std::cos(angle), 0.0, half * std::sin(angle)}, left{-half, 0, 0}, y{0, half, 0};
        add_quad(floor, left - y, -y, y, left + y);
        add_quad(floor, -y, up - y, up + y, y);
        dem::Setup<3> s = sphere_setup(sphere_contact(0.4));
        s.features.ledger = true;
        add_wall(s, mesh_of(floor));
        dem::Solver<3> solver(
            s, sphere({-0.02, 0.001, sphere_radius - weight / sphere_stiffness}, {0.3, 0, 0}, {0, 60, 0}));
        double const start = solver.energies().balance(), kinetic = solver.energies().kinetic();
        std::size_t most = 0;
        for (int n = 0; n < 8000; ++n) {
            solver.step(sphere_step);
            most = std::max(most, contacts_of(solver));
        }
        CHECK(solver.grains().place[0].centre.x > 0.01);
        CHECK(most == (angle < 0.023 ? 1 : 2));
        // a weight whose direction turns by the angle somewhere in a step: 2e-5 of the kinetic energy at 0.02 if it is
        // not booked
        CHECK(std::abs(solver.energies().balance() - start) < 1e-6 * kinetic);
    }
}

TEST_CASE("mesh: over hills, edges convex and concave, the ledger closes, the better the shorter the step")
{
    auto const drift = [](double dt) {
        dem::Random random(11);
        auto const hills = sheet(16, 0.05, {}, [&](double, double) { return random.uniform(-1e-3, 1e-3); });
        dem::Setup<3> s = sphere_setup(sphere_contact(0.3, dem::Rolling::elastic_plastic));
        s.features.ledger = true;
        add_wall(s, mesh_of(hills));
        dem::Solver<3> solver(s, sphere({-0.03, -0.02, 0.0065}, {0.3, 0.2, 0.0}));
        double const start = solver.energies().balance(), scale = solver.energies().kinetic();
        std::size_t most = 0;
        for (int n = 0; n < static_cast<int>(0.12 / dt); ++n) {
            solver.step(dt);
            most = std::max(most, contacts_of(solver));
        }
        CHECK(most >= 2);
        return std::abs(solver.energies().balance() - start) / scale;
    };
    CHECK(drift(sphere_step) < 1e-4);  // the mark of the ledger, as on planes
    CHECK(drift(sphere_step / 4.0) < 1e-4 / 4.0);
}

TEST_CASE("mesh: facets far finer than the sphere, and concave by less than the overlap, are one contact")
{
    // A tube of 1000 sides: neighbours differ by 6.3e-3, less than the cap at rest (2.7e-4 of a radius), 0.023.
    double const pi = std::numbers::pi, tube = 0.05;
    int const sides = 1000;
    double const least = sphere_radius * (1.0 - std::cos(2.0 * pi / sides));  // overlap of a cap of that angle
    Triangles wall;
    auto const at = [&](int k, double y) {
        double const angle = 2.0 * pi * (k + 0.5) / sides;
        return Vec3{tube * std::sin(angle), y, -tube * std::cos(angle)};
    };
    for (int k = 0; k < sides; ++k) add_quad(wall, at(k, -0.02), at(k + 1, -0.02), at(k + 1, 0.02), at(k, 0.02));
    dem::Setup<3> s = sphere_setup(sphere_contact(0.4, dem::Rolling::elastic_plastic));
    s.features.ledger = true;
    dem::Setup<3> round = s;
    add_wall(s, mesh_of(wall));
    add_wall(round, dem::Cylinder<3>{{}, {0, 1, 0}, tube, true});
    Vec3 const begin{0.02, 0.0, -std::sqrt((tube - sphere_radius) * (tube - sphere_radius) - 0.02 * 0.02) + 1e-5};
    dem::Solver<3> faceted(s, sphere(begin)), smooth(round, sphere(begin));
    double const start = faceted.energies().balance();
    int single = 0;
    for (int n = 0; n < 20000; ++n) {
        faceted.step(sphere_step), smooth.step(sphere_step);
        auto const numbers = dem::contact_numbers(faceted.setup(), faceted.state());
        single += numbers.contacts == 1;
        REQUIRE((numbers.contacts <= 1 || numbers.largest_overlap * 2.0 * sphere_radius < least));
    }
    CHECK(single > 10000);
    double const fall = smooth.grains().mass[0] * 9.81 * (begin.z + tube - sphere_radius);
    CHECK(std::abs(faceted.energies().balance() - start) < 1e-4 * fall);
    // The sides are nearer than the circle by up to tube (pi/sides)^2 / 2 = 2.5e-7 m, slopes off by pi/sides.
    CHECK(norm(faceted.grains().place[0].centre - smooth.grains().place[0].centre) < tube * pi / sides);
}

TEST_CASE("mesh: a grain that would go through a facet ends the run with its id and the time")
{
    dem::Setup<3> s = sphere_setup(sphere_contact(0.0));
    add_wall(s, mesh_of(flat(4, 0.05)), "sheet");
    auto const fly = [&](double speed) {
        dem::Solver<3> solver(s, sphere({1e-3, 2e-3, 0.01}, {0, 0, -speed}));
        for (int n = 0; n < 20000; ++n) solver.step(sphere_step);
        return solver.grains().place[0].centre.z;
    };
    // the spring holds v^2 m/2 = k R^2/2: v = R sqrt(k/m) = 13 m/s, and the dashpot
    CHECK(fly(9.0) > sphere_radius);
    CHECK_THROWS_WITH_AS(fly(40.0), doctest::Contains("the centre of grain 0 comes to wall \"sheet\" at t = 0.000"),
                         sluice::Error);
}

TEST_CASE("mesh: a moving mesh moves grains as a plane does, and one that is removed lets them fall")
{
    dem::Setup<3> s = sphere_setup(sphere_contact(0.4, dem::Rolling::elastic_plastic));
    s.features.ledger = true;
    auto const shaken = [&](dem::Shape<3> floor) {
        dem::Setup<3> moving = s;
        add_wall(moving, std::move(floor));
        moving.walls[0].motion.velocity = {0.05, 0.02, 0.0};
        moving.walls[0].motion.amplitude = {0.0, 0.001, 0.0005};
        moving.walls[0].motion.frequency = 30.0;
        moving.walls[0].removed_at = 0.15;
        dem::Solver<3> solver(moving, sphere({-0.004, 0.003, 0.0051}));
        double const start = solver.energies().balance();
        for (int n = 0; n < 11000; ++n) solver.step(sphere_step);
        CHECK(std::abs(solver.energies().wall_work) > 1e-6);
        CHECK(solver.grains().place[0].centre.z < 0.005);  // falls, 15 ms after
        CHECK(contacts_of(solver) == 0);
        return std::pair(solver.grains().place[0].centre, solver.energies().balance() - start);
    };
    auto const [on_mesh, drift] = shaken(mesh_of(flat(30, 0.05)));
    auto const [on_plane, plane_drift] = shaken(dem::Plane<3>{{}, {0, 0, 1}});
    // as above: rounding of distances; a wall that moves by 1e-2 m adds as much
    CHECK(norm(on_mesh - on_plane) < 1e-11 * sphere_radius);
    CHECK(std::abs(drift - plane_drift) < 1e-9 * 1e-4);  // what the wall does is 1e-4 J
}

TEST_CASE("mesh: the nearest point of a facet, and those that a tree finds, are the nearest of all")
{
    dem::Random random(7);
    auto const anywhere = [&](double size) {
        return Vec3{random.uniform(-size, size), random.uniform(-size, size), random.uniform(-size, size)};
    };
    Triangles triangles;
    for (int k = 0; k < 300; ++k) {
        Vec3 const at = anywhere(1.0);
        triangles.push_back({at, at + anywhere(0.2), at + anywhere(0.2)});
    }
    dem::Shape<3> const mesh = mesh_of(triangles);
    auto const& tree = *std::get<dem::Mesh<3>>(mesh).facets;
    std::vector<std::uint32_t> found;
    for (int k = 0; k < 300; ++k) {
        Vec3 const point = anywhere(1.2);
        double nearest = 1e9;
        std::vector<std::uint32_t> near;
        for (std::uint32_t f = 0; f < 300; ++f) {
            dem::Facet<3> const& facet = tree.facets()[f];
            auto const at = facet.facing(point);
            // the foot lies in the facet, and no corner lies before the plane through it: it is the nearest point
            Vec3 const foot = point - at.distance * at.normal;
            CHECK(facet.facing(foot).distance < 1e-14);
            for (Vec3 const& corner : facet.corner) CHECK(dot(corner - foot, at.normal) < 1e-14);
            nearest = std::min(nearest, at.distance);
            if (at.distance < 0.3) near.push_back(f);
        }
        CHECK(tree.facing(point).distance == nearest);
        tree.find_near(point, 0.3, found);
        CHECK(found == near);
    }
}

TEST_CASE("mesh: discs on a line cut into segments move as on a line, and rest in a groove on two")
{
    auto const roll = [](dem::Shape<2> floor) {
        dem::Setup<2> s = setup(0.5, {0.0, -9.81}, true);
        s.features.rolling = dem::Rolling::elastic_plastic;
        s.law = dem::contact_law(rolling_contact(0.5, dem::Rolling::elastic_plastic));
        s.walls.push_back({.name = "floor", .shape = std::move(floor), .motion = {}, .law = s.law});
        dem::Grains<2> g;
        g.add({-0.01, 1.5e-3}, 1e-3, density, {{0.2, -0.1}, 30.0});
        dem::Solver<2> solver(s, g);
        for (int n = 0; n < 40000; ++n) solver.step(step);
        return std::pair(solver.grains().place[0].centre, solver.energies());
    };
    std::vector<std::array<dem::Vec2, 2>> line;
    for (int k = -60; k < 60; ++k) line.push_back({dem::Vec2{k * 4e-4, 0.0}, {(k + 1) * 4e-4, 0.0}});
    auto const [on_line, a] = roll(dem::Plane<2>{{}, {0, 1}});
    auto const [on_segments, b] = roll(mesh_of(line));
    CHECK(norm(on_line - on_segments) < 1e-11 * 1e-3);
    CHECK(on_line.x > -0.005);
    CHECK(std::abs(a.balance() - b.balance()) < 1e-10 * a.sliding);

    dem::Setup<2> s = setup(0.0);
    s.walls.push_back({.name = "groove",
                       .shape = mesh_of({{dem::Vec2{-0.01, 0.01}, {}}, {dem::Vec2{}, {0.01, 0.01}}}),
                       .motion = {},
                       .law = s.law});
    dem::Grains<2> g;
    g.add({0.0, 1.5e-3}, 1e-3, density);
    dem::Solver<2> solver(s, g);
    for (int n = 0; n < 20000; ++n) solver.step(step);
    double const force = density * dem::volume_of<2>(1e-3) * 9.81 * std::sqrt(0.5);
    // falls for 4 ms; exp(-0.2 x 1.1e4/s x 0.03 s) is nothing
    CHECK(solver.grains().place[0].centre.y == close_to(std::sqrt(2.0) * (1e-3 - force / stiffness)).epsilon(1e-9));
}
