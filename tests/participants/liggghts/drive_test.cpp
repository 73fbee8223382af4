#include "participants/liggghts/drive.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <fstream>

#include "coupler/base/error.hpp"
#include "participants/liggghts/observer.hpp"
#include "tests/support/close_to.hpp"
#include "tests/support/contains.hpp"
#include "tests/support/liggghts_scene.hpp"

namespace {

using dem::Vec3;
using liggghts::Loads;
using liggghts_scene::read;
using liggghts_scene::Scene;

std::string const matter = "density: 2500\ncontact: {normal_stiffness: 1e5, damping_ratio: 0.1, friction: 0.3}\n";

//! Grains in a cube that do not touch, of three sizes.
std::string grains_apart(int along)
{
    std::string text = "grains:\n";
    for (int k = 0; k < along * along * along; ++k) {
        auto const at = [&](int of) { return std::to_string(0.02 * (of % along)); };
        text += "  - {position: [" + at(k) + ", " + at(k / along) + ", " + at(k / along / along) +
                "], radius: " + std::to_string(0.003 + 0.001 * (k % 3)) + ", spin: [0, 0, " + std::to_string(k) +
                "]}\n";
    }
    return text;
}

//! A load that differs from grain to grain and step to step.
dem::Load<3> load_of(std::size_t tag, double time)
{
    auto const k = static_cast<double>(tag);
    return {Vec3{1e-3 * k, -2e-3 + 0.1 * time, 1e-3 * std::sin(300.0 * time + k)},
            Vec3{1e-6 * k, 1e-6 * std::cos(200.0 * time), -1e-6}};
}

Loads loads_at(std::size_t count, double time)
{
    std::vector<std::array<double, 6>> acting;
    for (std::size_t tag = 1; tag <= count; ++tag) {
        auto const [force, torque] = load_of(tag, time);
        acting.push_back({force.x, force.y, force.z, torque.x, torque.y, torque.z});
    }
    return liggghts_scene::loads_of(acting);
}

double largest(double a, Vec3 const& b)
{
    return std::max(a, norm(b));
}

}  // namespace

TEST_CASE("drive: grains under loads of any course go where our DEM has them, at whatever ends of windows")
{
    Scene<3> scene(read(matter + grains_apart(3), 3, {0, 0, -9.81}));
    dem::Solver<3> ours = dem::make_solver<3>(scene.config());
    std::size_t const count = 27;
    double const dt = 1e-5;
    std::int64_t done = 0;
    for (std::int64_t const steps : {1, 7, 40, 200, 1, 500}) {
        auto const time = [&](std::int64_t step) { return (static_cast<double>(done + step) + 0.5) * dt; };
        scene.drive().advance(
            steps, dt, [&](std::int64_t step, Loads& loads) { loads = loads_at(count, time(step)); }, true);
        for (std::int64_t step = 0; step < steps; ++step) {
            for (std::size_t i = 0; i < count; ++i) ours.grains().external[i] = load_of(i + 1, time(step));
            ours.step(dt);
        }
        done += steps;
        auto const theirs = scene.grains();
        double place = 0.0, velocity = 0.0, spin = 0.0;
        for (std::size_t i = 0; i < count; ++i) {
            place = largest(place, theirs.place[i].centre - ours.grains().place[i].centre);
            velocity = largest(velocity, theirs.motion[i].velocity - ours.grains().motion[i].velocity);
            spin = largest(spin, theirs.motion[i].spin - ours.grains().motion[i].spin);
        }
        // rounding of 1e3 steps, of lengths of 0.05 m, speeds of 1 m/s, spins of 30 rad/s
        CHECK(place < 1e-14);
        CHECK(velocity < 1e-13);
        CHECK(spin < 1e-11);
    }
}

TEST_CASE("drive: loads that stay act as in one window, however it is divided")
{
    auto const config = read(matter + grains_apart(2), 3, {0, 0, -9.81});
    auto const loads = loads_at(8, 0.0);
    auto const same = [&](std::int64_t, Loads& now) { now = loads; };
    Scene<3> whole(config);
    auto const given = whole.drive().advance(300, 1e-5, same, false);
    auto const reference = whole.grains();
    Scene<3> divided(config);
    dem::Vec3 impulse{};
    double work = 0.0;
    for (std::int64_t const steps : {100, 1, 199}) {
        auto const part = divided.drive().advance(steps, 1e-5, same, false);
        impulse += dem::Vec3{part.impulse[0], part.impulse[1], part.impulse[2]};
        work += part.work;
    }
    auto const grains = divided.grains();
    for (std::size_t i = 0; i < grains.size(); ++i) {
        CHECK(norm(grains.place[i].centre - reference.place[i].centre) < 1e-16);
        CHECK(norm(grains.motion[i].velocity - reference.motion[i].velocity) < 1e-16);
    }
    CHECK(work == close_to(given.work).epsilon(1e-12));
    dem::Vec3 sum{};
    for (std::size_t k = 0; k < loads.force.size(); k += 3)
        sum += Vec3{loads.force[k], loads.force[k + 1], loads.force[k + 2]};
    CHECK(norm(impulse - 300 * 1e-5 * sum) < 1e-12 * norm(impulse));
    auto const [x, y, z] = given.impulse;
    CHECK(norm(Vec3{x, y, z} - impulse) < 1e-12 * norm(impulse));
    // what the loads did is what the grains have, but for their weight
    double energy = 0.0;
    dem::Grains<3> const start = dem::listed_grains<3>(config);
    for (std::size_t i = 0; i < grains.size(); ++i) {
        auto const [v, w] = grains.motion[i];
        auto const w0 = start.motion[i].spin;
        energy += 0.5 * grains.mass[i] * dot(v, v) + 0.5 * grains.inertia[i] * (dot(w, w) - dot(w0, w0)) +
                  9.81 * grains.mass[i] * (grains.place[i].centre.z - start.place[i].centre.z);
    }
    CHECK(given.work == close_to(energy).epsilon(1e-9));
}

TEST_CASE("drive: discs have the mass and the inertia of discs, per metre")
{
    Scene<2> scene(
        read("density: 2650\ncontact: {normal_stiffness: 1e6, damping_ratio: 0.2, friction: 0.5}\n"
             "grains: [{position: [0.01, 0.02], radius: 0.001, spin: 2}]\n",
             2));
    double const mass = 2650.0 * std::acos(-1.0) * 1e-6, inertia = 0.5 * mass * 1e-6;
    auto const loads = liggghts_scene::loads_of({{1e-3, -2e-3, 0, 0, 0, 3e-7}});
    scene.drive().advance(
        100, 1e-5, [&](std::int64_t, auto& now) { now = loads; }, false);
    auto const grains = scene.grains();
    CHECK(grains.mass[0] == close_to(mass).epsilon(1e-14));
    CHECK(grains.motion[0].velocity.x == close_to(1e-3 / mass * 1e-3).epsilon(1e-12));
    CHECK(grains.motion[0].velocity.y == close_to(-2e-3 / mass * 1e-3).epsilon(1e-12));
    CHECK(grains.motion[0].spin == close_to(2.0 + 3e-7 / inertia * 1e-3).epsilon(1e-12));
}

TEST_CASE("drive: a wall holds a grain until it is removed")
{
    std::string const keys = matter +
                             "walls: [{name: shelf, point: [0, 0, 0], normal: [0, 0, 1], removed_at: 0.02}]\n"
                             "grains: [{position: [0, 0, 0.004], radius: 0.004}]\n";
    Scene<3> scene(read(keys, 3, {0, 0, -9.81}));
    auto const nothing = [](std::int64_t, Loads& loads) { loads.reset({}); };
    double const dt = 1e-5;
    scene.drive().advance(2000, dt, nothing, false, {{1000, liggghts::wall_name(0)}});
    double const fallen = 1000 * dt;
    auto const grains = scene.grains();
    // while it stands it sinks in by twice m g / kn = 7e-8 m at most, at 8e-4 m/s at most
    CHECK(std::abs(grains.motion[0].velocity.z + 9.81 * fallen) < 8e-4);
    CHECK(std::abs(grains.place[0].centre.z - (0.004 - 0.5 * 9.81 * fallen * fallen)) < 8e-4 * fallen + 2e-7);
}

TEST_CASE("script: a mistake is one message with the script's line and LIGGGHTS' own words")
{
    auto& [folder, engine] = liggghts_scene::place();
    auto const script = folder.path() / "in.bad";
    auto const said = [&](std::string const& text) -> std::string {
        std::ofstream(script) << text;
        engine.command("clear", "scene");
        try {
            liggghts::run_script(engine, script, {});
        } catch (sluice::Error const& e) {
            CHECK(e.exit() == sluice::Exit::config);
            return e.what();
        }
        return "";
    };
    CHECK(contains(said("units si\n\n# a remark\natom_stile granular\n"), "in.bad:4: LIGGGHTS stops: Unknown command"));
    auto const continued = said("units si\natom_stile &\n  granular\nboundary f f f\n");
    CHECK(contains(continued, "in.bad:2: LIGGGHTS stops: Unknown command"));
    CHECK(contains(said("units si\nfix a all nve/sphere\n"), "in.bad:2: LIGGGHTS stops: "));
    CHECK(contains(said("quit\n"), "in.bad:1: LIGGGHTS stops: the script ends the program"));
}

TEST_CASE("observer: a grain that has come through a wall ends the run")
{
    auto const config = read(matter +
                                 "walls: [{name: floor, point: [0, 0, 0], normal: [0, 0, 1]}]\n"
                                 "grains: [{position: [0, 0, 0.005], radius: 0.004}]\n",
                             3, {0, 0, -9.81});
    liggghts::Observer<3> observer(dem::make_setup<3>(config));
    auto grains = dem::listed_grains<3>(config);
    auto const energies = observer.look(grains, 0.25, 0.125).energies();
    CHECK(energies.potential == close_to(grains.mass[0] * 9.81 * 0.005).epsilon(1e-12));
    CHECK(energies.external_work == 0.125);
    CHECK(std::isnan(energies.sliding));
    grains.place[0].centre.z = -0.001;
    CHECK_THROWS_WITH_AS(observer.look(grains, 0.25, 0.0), doctest::Contains("behind wall \"floor\""), sluice::Error);
}
