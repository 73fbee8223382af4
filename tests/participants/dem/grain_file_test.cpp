#include "participants/dem/grain_file.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>
#include <string>

#include "coupler/base/error.hpp"
#include "coupler/base/scratch_directory.hpp"
#include "tests/participants/dem/scenes.hpp"
#include "tests/support/close_to.hpp"

using namespace unit;

namespace {

std::filesystem::path const samples = SAMPLES;

std::filesystem::path written(sluice::ScratchDirectory const& folder, std::string const& text)
{
    auto const file = folder.path() / "grains.txt";
    std::ofstream(file, std::ios::binary) << text;
    return file;
}

std::vector<dem::GrainConfig> read(std::filesystem::path const& file, int dimension,
                                   std::optional<std::int64_t> timestep = std::nullopt)
{
    std::vector<std::string> warnings;
    auto const grains = dem::read_grain_file(file, dimension, timestep, warnings);
    CHECK(warnings.empty());
    return grains;
}

std::vector<dem::GrainConfig> read_text(std::string const& text, int dimension,
                                        std::optional<std::int64_t> timestep = std::nullopt)
{
    sluice::ScratchDirectory const folder("grains");
    return read(written(folder, text), dimension, timestep);
}

//! The message for a text that is refused, from the name of the file on.
std::string refusal(std::string const& text, int dimension, std::optional<std::int64_t> timestep = std::nullopt)
{
    try {
        read_text(text, dimension, timestep);
    } catch (sluice::Error const& e) {
        CHECK(e.exit() == sluice::Exit::config);
        std::string const message = e.what();
        return message.substr(message.find("grains.txt"));
    }
    return "not refused";
}

dem::GrainConfig const& by_id(std::vector<dem::GrainConfig> const& grains, std::int64_t id)
{
    auto const found = std::find_if(grains.begin(), grains.end(), [&](auto const& g) { return g.id == id; });
    REQUIRE(found != grains.end());
    return *found;
}

bool same(dem::GrainConfig const& a, dem::GrainConfig const& b)
{
    return a.position == b.position && a.radius == b.radius && a.velocity == b.velocity && a.spin == b.spin &&
           a.density == b.density && a.id == b.id;
}

//! Places agree to the six digits of a dump.
void check_same_places(std::vector<dem::GrainConfig> const& a, std::vector<dem::GrainConfig> const& b, double within)
{
    REQUIRE(a.size() == b.size());
    for (auto const& grain : a) {
        CHECK(norm(grain.position - by_id(b, grain.id).position) < within);
        CHECK(grain.radius == by_id(b, grain.id).radius);
    }
}

std::string replaced(std::string text, std::string const& from, std::string const& to)
{
    auto const at = text.find(from);
    REQUIRE(at != std::string::npos);
    return text.replace(at, from.size(), to);
}

std::string const csv =
    "# two discs\n"
    "x [m], y [m], diameter, vx, wz, id, density\n"
    "0.01, 0.02, 2e-3, 0.5, -3, 17, 2500\n"
    "\n"
    "0.03, 0.02, 4e-3, 0, 0, 4, 2600\n";
std::string const dump =
    "ITEM: TIMESTEP\n100\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS pp ff pp\n0 0.1\n0 0.1\n-0.5 0.5\n"
    "ITEM: ATOMS id type xu ys z radius fx\n1 1 0.12 0.5 0 0.001 9\n2 1 -0.03 0.25 0 0.002 nan\n"
    "ITEM: TIMESTEP\n200\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS pp ff pp\n0 0.1\n0 0.1\n-0.5 0.5\n"
    "ITEM: ATOMS id type xu ys z radius fx\n1 1 0.13 0.5 0 0.001 9\n2 1 -0.03 0.25 0 0.002 9\n";
std::string const data =
    "two spheres\n\n2 atoms\n1 atom types\n\n0 1 xlo xhi\n0 1 ylo yhi\n0 1 zlo zhi\n\nAtoms # sphere\n\n"
    "7 1 0.02 2650 0.1 0.2 0.3\n5 1 0.04 2650 0.4 0.5 0.6\n\nVelocities\n\n5 1 2 3 4 5 6\n7 0 0 0 0 0 1\n";

}  // namespace

TEST_CASE("grain file: a CSV with a header, comments, units and ids of its own")
{
    for (std::string const& text : {csv, "\xef\xbb\xbf" + replaced(csv, "\n\n", "\r\n\r\n")}) {
        auto const grains = read_text(text, 2);
        REQUIRE(grains.size() == 2);
        CHECK(grains[0].position == dem::Vec3{0.01, 0.02, 0.0});
        CHECK(grains[0].radius == 1e-3);
        CHECK(grains[0].velocity == dem::Vec3{0.5, 0.0, 0.0});
        CHECK(grains[0].spin == dem::Vec3{0.0, 0.0, -3.0});
        CHECK(grains[0].id == 17);
        CHECK(grains[1].id == 4);
        CHECK(grains[1].density == 2600.0);
    }
    auto const plain = read_text("z,y,x,radius\n3,2,1,0.5\n6,5,4,0.5", 3);
    CHECK(plain[1].position == dem::Vec3{4, 5, 6});
    CHECK(plain[1].id == 1);
    CHECK(plain[1].density == 0.0);
}

TEST_CASE("grain file: a broken CSV is refused at its line")
{
    auto const check = [](std::string const& from, std::string const& to, std::string const& message) {
        CHECK(refusal(replaced(csv, from, to), 2) == "grains.txt:" + message);
    };
    check("0.03, 0.02", "0.03, fast", "5: y = \"fast\" is not a number (needed: one).");
    check("0.03, 0.02", "nan, 0.02", "5: x = nan m (must be -1e+06 to 1e+06).");
    check("4e-3", "-4e-3", "5: diameter = -0.004 m (must be 2e-09 to 2000).");
    check("4e-3", "0", "5: diameter = 0 m (must be 2e-09 to 2000).");
    check(", 2600\n", "\n", "5: has 6 values (needed: 7, one for each column). Was its writer stopped?");
    check("0, 4, 2600", "0, 17, 2600", "5: id = 17 is that of line 3 (must be different).");
    check("0, 4, 2600", "0, 4.5, 2600", "5: id = 4.5 (must be a whole number).");
    check("0, 4, 2600", "0, -4, 2600", "5: id = -4 (must be 0 to 9e+15).");
    check("vx, wz", "vx, vx", "2: the header has two columns vx (needed: one).");
    check("x [m]", "x [mm]", "2: x is in \"mm\" (needed: \"m\").");
    check(
        "diameter,", "dimeter,",
        "2: the header has a column \"dimeter\" (columns: id, x, y, z, radius, diameter, density, vx, vy, vz, wx, wy, "
        "wz). Did you mean diameter?");
    check("diameter,", "vy,", "2: the header has neither radius nor diameter (needed: one of them).");
    check("x [m],", "z,", "2: the header has no column x (needed: x, y, radius or diameter).");
    CHECK(refusal(csv, 3) == "grains.txt:2: the header has no column z (needed: x, y, z, radius or diameter).");
    CHECK(refusal("1,2,3\n", 2).find("1: the header has a column \"1\"") != std::string::npos);
    CHECK(refusal("1,2,3\n", 2).find("The first line must be a header.") != std::string::npos);
    CHECK(refusal("x;y;radius\n1;2;3\n", 2).find("Columns are parted by commas.") != std::string::npos);
    CHECK(refusal("x,y,z,radius\n1,2,0.5,1\n", 2) == "grains.txt:2: z = 0.5 m (must be 0: the scene is a plane).");
    CHECK(refusal("x,y,vz,radius\n1,2,0.5,1\n", 2) ==
          "grains.txt:2: vz = 0.5 m/s leaves the plane (must be 0: the scene is one).");
    CHECK(refusal("x,y,radius,diameter\n1,2,0.5,0.5\n", 2) ==
          "grains.txt:2: radius = 0.5 m, but diameter = 0.5 m (must be twice the radius).");
    CHECK(refusal("", 2) == "grains.txt:1: is empty (needed: a CSV with a header, a dump of atoms, or a data file).");
    CHECK(refusal("x,y,radius\n", 2) == "grains.txt:1: holds no grains (needed: at least one).");
    CHECK(refusal(csv, 2, 100) == "grains.txt:1: is no dump: it has no timesteps (leave timestep out).");
    CHECK_THROWS_WITH_AS(read("/nowhere/grains.csv", 2), doctest::Contains("/nowhere/grains.csv cannot be read"),
                         sluice::Error);
    CHECK_THROWS_WITH_AS(read("/tmp", 2), doctest::Contains("cannot be read"), sluice::Error);
}

TEST_CASE("grain file: a dump's last frame or another one, places in parts of the box, and unwound ones put back")
{
    auto const last = read_text(dump, 2);
    REQUIRE(last.size() == 2);
    CHECK(last[0].position.x == close_to(0.03));  // 0.13 in a periodic box of 0.1
    CHECK(last[0].position.y == close_to(0.05));  // half the box
    CHECK(last[1].position.x == close_to(0.07));  // -0.03
    CHECK(read_text(dump, 2, 100)[0].position.x == close_to(0.02));
    CHECK(read_text(replaced(dump, "xu ys", "x y"), 2, 100)[0].position.x == 0.12);  // places are taken as they are
    CHECK(read_text(replaced(dump, "pp ff pp", "ff ff ff"), 2, 100)[0].position.x == 0.12);
}

TEST_CASE("grain file: a broken dump is refused at its line")
{
    CHECK(refusal(dump, 2, 150) ==
          "grains.txt:22: no frame is of timestep 150 (there: 2 frames from timestep 100 to 200).");
    CHECK(
        refusal(dump.substr(0, dump.rfind("2 1 ")), 2) ==
        "grains.txt:21: the frame ends after 1 of 2 grains. Was its writer stopped? Give the timestep of another frame "
        "(there: 2 frames from timestep 100 to 200).");
    CHECK(refusal(dump.substr(0, dump.size() - 3), 2) ==
          "grains.txt:22: has 6 values (needed: 7, one for each column). Was its writer stopped?");
    CHECK(refusal(replaced(dump, "ys z radius", "ys z size"), 2, 100).find("9: has neither radius nor diameter") !=
          std::string::npos);
    CHECK(refusal(replaced(dump, "type xu", "type q"), 2, 100) ==
          "grains.txt:9: has no column x, xs or xu (needed: one of them).");
    CHECK(refusal(replaced(dump, "BOUNDS pp ff pp", "BOUNDS xy xz yz pp ff pp"), 2, 100) ==
          "grains.txt:9: has xu in an oblique box (needed: column x).");
    CHECK(refusal(replaced(dump, "0 0.1\n", "0\n"), 2, 100) ==
          "grains.txt:6: is no side of a box (needed: two numbers, ascending).");
    CHECK(refusal("ITEM: UNITS\nlj\n" + dump, 2) == "grains.txt:2: units are lj (needed: si).");
    CHECK(refusal("ITEM: NUMBER OF ATOMS\n1\n", 2) == "grains.txt:2: has no ITEM: TIMESTEP (needed: a dump of atoms).");
    CHECK(refusal(replaced(dump, "1 1 0.12 0.5 0", "1 1 0.12 0.5 0.3"), 2, 100) ==
          "grains.txt:10: z = 0.3 m (must be 0: the scene is a plane).");
}

TEST_CASE("grain file: a data file with velocities in another order")
{
    auto const grains = read_text(data, 3);
    REQUIRE(grains.size() == 2);
    CHECK(grains[0].id == 7);
    CHECK(grains[0].spin == dem::Vec3{0, 0, 1});
    CHECK(grains[1].radius == 0.02);
    CHECK(grains[1].position == dem::Vec3{0.4, 0.5, 0.6});
    CHECK(grains[1].velocity == dem::Vec3{1, 2, 3});
    CHECK(grains[1].spin == dem::Vec3{4, 5, 6});
    CHECK(grains[1].density == 2650.0);
}

TEST_CASE("grain file: a broken data file is refused at its line")
{
    auto const check = [](std::string const& from, std::string const& to, std::string const& message) {
        CHECK(refusal(replaced(data, from, to), 3) == "grains.txt:" + message);
    };
    check("# sphere", "# atomic",
          "10: atoms are of style atomic (needed: sphere, that is id, type, diameter, density, x, y, z).");
    check("2 atoms", "3 atoms", "15: Atoms end after 2 of 3 rows, as the header has it. Was its writer stopped?");
    check("0.1 0.2 0.3", "0.1 0.2",
          "12: has 6 values (needed: id, type, diameter, density, x, y, z, and 3 images or none).");
    check("0.4 0.5 0.6", "0.4 0.5", "13: has 6 values (needed: 7, one for each column). Was its writer stopped?");
    check("5 1 2 3", "6 1 2 3", "17: a velocity of atom 6, which is not among the Atoms before it.");
    check("7 0 0 0 0 0 1\n", "", "17: Velocities end after 1 of 2 rows, as the header has it. Was its writer stopped?");
    check("two spheres", "a file, units = lj", "1: units are not si (needed: units = si).");
    check("Atoms # sphere", "Molecules", "17: a velocity of atom 5, which is not among the Atoms before it.");
    CHECK(refusal("nothing\n\n2 atoms\n", 3) == "grains.txt:3: has no section Atoms (needed: `Atoms # sphere`).");
}

TEST_CASE("grain file: what LIGGGHTS and LAMMPS wrote")
{
    auto const falling = read(samples / "liggghts.dump", 3), before = read(samples / "liggghts.dump", 3, 2000);
    REQUIRE(falling.size() == 40);
    CHECK(by_id(falling, 13).position == dem::Vec3{0.0278924, 0.027353, 0.00347913});
    CHECK(by_id(falling, 13).velocity.z == -0.196175);
    CHECK(by_id(falling, 13).density == 2650.0);
    CHECK(by_id(before, 13).position.z == 0.00495039);
    CHECK_THROWS_WITH_AS(read(samples / "liggghts.dump", 3, 0), doctest::Contains("holds no grains"), sluice::Error);
    // six digits: of a part of the box, 0.1 m high
    check_same_places(falling, read(samples / "liggghts_scaled.dump", 3), 1e-6);
    check_same_places(falling, read(samples / "liggghts_unwound.dump", 3), 1e-7);

    auto const plane = read(samples / "lammps_plane.data", 2);
    REQUIRE(plane.size() == 32);
    CHECK(by_id(plane, 3).density == 2500.0);
    CHECK(by_id(plane, 3).spin == dem::Vec3{0, 0, 3});
    CHECK(by_id(plane, 3).position.x == 0.012744848453127337);
    check_same_places(plane, read(samples / "lammps_plane.dump", 2), 1e-7);
    check_same_places(read(samples / "lammps_space.data", 3), read(samples / "lammps_space.dump", 3), 1e-7);
}

TEST_CASE("grain file: grains of several types are warned about, for there is one law")
{
    sluice::ScratchDirectory const folder("grains");
    for (std::string const& text : {replaced(data, "5 1 0.04", "5 2 0.04"), replaced(dump, "2 1 -0.03", "2 4 -0.03")}) {
        std::vector<std::string> warnings;
        dem::read_grain_file(written(folder, text), text[0] == 'I' ? 2 : 3,
                             text[0] == 'I' ? std::optional<std::int64_t>(100) : std::nullopt, warnings);
        REQUIRE(warnings.size() == 1);
        CHECK(warnings[0].find("several types") != std::string::npos);
    }
}

TEST_CASE("grain file: sorted in space, whatever the order was")
{
    dem::Random random(7);
    std::vector<dem::GrainConfig> grains;
    for (int k = 0; k < 1000; ++k) {
        dem::GrainConfig g{};
        g.position = {random.uniform(), random.uniform(), random.uniform(0.0, 2.0)};
        g.radius = random.uniform(0.01, 0.05);
        g.id = k;
        grains.push_back(g);
    }
    auto scrambled = grains;
    for (std::size_t k = 999; k > 0; --k) std::swap(scrambled[k], scrambled[random.next() % (k + 1)]);
    dem::sort_in_space(grains);
    dem::sort_in_space(scrambled);
    bool equal = true;
    for (std::size_t k = 0; k < 1000; ++k) equal = equal && same(grains[k], scrambled[k]);
    CHECK(equal);
    CHECK(grains[0].position.z < 0.06);
    CHECK(grains[999].position.z > 1.94);
}

namespace {

//! The column of the scene as a file's text, in the order of `order`.
std::string csv_of(dem::Grains<2> const& g, std::vector<std::size_t> const& order)
{
    std::ostringstream out;
    out.precision(17);
    out << "id,x,y,radius,vx,vy\n";
    for (std::size_t const i : order)
        out << 100 + i << ',' << g.place[i].centre.x << ',' << g.place[i].centre.y << ',' << g.place[i].radius << ','
            << g.motion[i].velocity.x << ',' << g.motion[i].velocity.y << '\n';
    return out.str();
}

std::string const walls_and_file =
    "density: 2650\ncontact: {normal_stiffness: 1e6, damping_ratio: 0.2, friction: 0.5}\n"
    "walls:\n"
    "  - {name: floor, point: [0, 0], normal: [0, 1]}\n"
    "  - {name: left, point: [0, 0], normal: [1, 0]}\n"
    "  - {name: right, point: [0.0228, 0], normal: [-1, 0]}\n";

}  // namespace

TEST_CASE("grain file: a scrambled file gives the same bits as a sorted one, and what its own order gives to rounding")
{
    sluice::ScratchDirectory const folder("grains");
    dem::Grains<2> const g = loose(12, 5, 0.3);
    std::vector<std::size_t> order(g.size()), scrambled;
    for (std::size_t i = 0; i < g.size(); ++i) order[i] = i;
    scrambled = order;
    dem::Random random(3);
    for (std::size_t k = g.size() - 1; k > 0; --k) std::swap(scrambled[k], scrambled[random.next() % (k + 1)]);
    auto const config_of = [&](std::vector<std::size_t> const& rows) {
        return config(walls_and_file + "packing: {file: " + written(folder, csv_of(g, rows)).string() + "}\n");
    };
    dem::Config const sorted_config = config_of(order), scrambled_config = config_of(scrambled);
    CHECK(sorted_config.grains_hash == scrambled_config.grains_hash);
    dem::Solver<2> a = dem::make_solver<2>(sorted_config), b = dem::make_solver<2>(scrambled_config);
    dem::Config unsorted = scrambled_config;
    std::sort(unsorted.grains.begin(), unsorted.grains.end(), [](auto const& p, auto const& q) { return p.id < q.id; });
    dem::Solver<2> c = dem::make_solver<2>(unsorted);
    auto const worst_difference = [&] {
        double worst = 0.0;
        for (std::size_t i = 0; i < g.size(); ++i) {
            auto const& id = c.grains().id;
            auto const at = std::find(id.begin(), id.end(), a.grains().id[i]) - id.begin();
            auto const there = c.grains().place[static_cast<std::size_t>(at)].centre;
            worst = std::max(worst, norm(a.grains().place[i].centre - there));
        }
        return worst;
    };
    // every collision turns a rounding into some R / (R xi)^(1/2) times more: over the few collisions of 500 steps
    // (1 ms) it stays rounding, over a whole fall it does not
    for (int n = 0; n < 500; ++n) a.step(step), b.step(step), c.step(step);
    CHECK(a.grains().id == b.grains().id);
    CHECK(worst_difference() < 1e-10 * 1e-3);
    CHECK(a.state().pairs.other != c.state().pairs.other);  // another order indeed
    for (int n = 0; n < 10000; ++n) a.step(step), b.step(step);
    bool equal = true;
    for (std::size_t i = 0; i < g.size(); ++i)
        equal = equal && a.grains().place[i].centre == b.grains().place[i].centre &&
                a.grains().motion[i].velocity == b.grains().motion[i].velocity;
    CHECK(equal);
}

TEST_CASE("config: a packing from a file, its densities, its ids and its speeds")
{
    sluice::ScratchDirectory const folder("grains");
    auto const file = written(folder, csv);
    std::string const head = "contact: {normal_stiffness: 1e6, damping_ratio: 0.2, friction: 0.5}\n";
    auto const packing = [&](std::string const& more) {
        return head + "packing: {file: " + file.string() + more + "}\n";
    };
    dem::Solver<2> const own = dem::make_solver<2>(config(packing("")));
    CHECK(own.grains().id == std::vector<std::int64_t>{17, 4});
    CHECK(own.grains().mass[1] == close_to(2600 * std::numbers::pi * 4e-6));
    CHECK(own.grains().motion[0].velocity.x == 0.5);
    CHECK(own.grains().motion[0].spin == -3.0);
    dem::Config const c = config(packing(", velocities: zero") + "density: 1000\n");
    dem::Solver<2> const given = dem::make_solver<2>(c);
    CHECK(given.grains().mass[1] == close_to(1000 * std::numbers::pi * 4e-6));
    CHECK(given.grains().motion[0].velocity.x == 0.0);
    CHECK(c.grains_hash != config(packing("")).grains_hash);
    // the lightest grain counts for the step: of 2500 kg/m3 and 1 mm
    CHECK(config(packing("")).contact_time ==
          close_to(dem::contact_time_of(config(packing("")).contact, 2, 2500 * std::numbers::pi * 1e-6, 1e-3)));
    CHECK_THROWS_WITH_AS(config(packing("") + "buoyancy: {density: 1000}\n"),
                         doctest::Contains("needs grains of one density"), sluice::Error);
    CHECK_NOTHROW(config(packing("") + "density: 2650\nbuoyancy: {density: 1000}\n"));
    CHECK_THROWS_WITH_AS(config(packing(", timestep: 3")), doctest::Contains("is no dump"), sluice::Error);
    CHECK_THROWS_WITH_AS(config(std::string(scene) + "packing: {file: x}\n"), doctest::Contains("beside column"),
                         sluice::Error);
}

TEST_CASE("config: a packing's path counts from the scene's folder, and its mistakes come with both places")
{
    sluice::ScratchDirectory const folder("grains");
    written(folder, "x,y,radius\n0,0.1,0.001\n0,0.2,-1\n");
    std::string const text = walls_and_file + "packing: {file: grains.txt}\n";
    try {
        dem::read_config(sluice::read_yaml(text, (folder.path() / "scene.yaml").string()), 2, {0, -9.81, 0});
        FAIL("no error");
    } catch (sluice::Error const& e) {
        std::string const there = folder.path().string();
        CHECK(e.what() == there + "/scene.yaml:7:17: packing.file = grains.txt cannot be used: " + there +
                              "/grains.txt:3: radius = -1 m (must be 1e-09 to 1000).");
    }
}
