//! Speed of spheres in a dense settled column beside the real LIGGGHTS and LAMMPS (Debian's packages; without them
//! their lines are left out): the same grains, walls, step and, for LIGGGHTS, the same laws. Prints a table; `--json
//! FILE` writes a list of {case, metric, value, unit, against, ratio}; `--small`: a smoke run; `--large`: 100 000
//! grains, too. Times are processor time, a peer's by the difference of a long and a short run: other work on the
//! machine then counts less; on two cores it is the wall's. All run one after another in each repetition; the table has
//! the medians.
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "coupler/base/scratch_directory.hpp"
#include "participants/dem/config.hpp"
#include "participants/dem/packing_file.hpp"
#include "participants/dem/random.hpp"
#include "participants/dem/solver.hpp"

namespace {

using dem::Vec3;

constexpr double density = 2650.0, mean_radius = 4e-3, kn = 1e5, kt = 2e5 / 7.0, mu = 0.5, mu_r = 0.079;
constexpr double gamma_n = 0.953, gamma_t = 0.477;  // N s/m
constexpr double step = 5e-6;                       // s
constexpr int warm_up = 100;

nlohmann::json results = nlohmann::json::array();

double side_of(std::size_t grains)  // of a column about as high as wide [m]
{
    return 2.0 * mean_radius * std::cbrt(static_cast<double>(grains)) * 1.03;
}

dem::Setup<3> setup_of(double side)
{
    dem::Setup<3> s;
    s.gravity = {0.0, 0.0, -9.81};
    s.law.normal = {.stiffness = kn, .damping = gamma_n, .floor = -std::numeric_limits<double>::infinity()};
    s.law.tangential = {.stiffness = kt, .damping = gamma_t, .friction = mu};
    s.law.rolling = {.friction = mu_r};
    s.skin = 1e-3;
    s.absolute_damping = true;
    s.loads = false;
    s.features = {.friction = true, .rolling = dem::Rolling::constant, .scheme = dem::Scheme::liggghts};
    auto const wall = [&](Vec3 point, Vec3 normal) {
        s.walls.push_back({.name = "w", .shape = dem::Plane<3>{point, normal}, .motion = {}, .law = s.law});
    };
    wall({}, {0, 0, 1});
    wall({}, {1, 0, 0});
    wall({}, {0, 1, 0});
    wall({side, 0, 0}, {-1, 0, 0});
    wall({0, side, 0}, {0, -1, 0});
    return s;
}

//! Spheres of 8 mm +- 10 % that came to rest from a loose lattice, kept for the next run.
dem::Grains<3> settled(std::size_t count)
{
    double const side = side_of(count);
    char const* const home = std::getenv("HOME");
    std::filesystem::path const file = std::filesystem::path(home ? home : "/tmp") / ".cache" / "sluice" /
                                       ("bench-column-" + std::to_string(count) + ".bin");
    std::string damage;
    dem::Grains<3> g;
    if (auto const kept = dem::load_packing<3>(file, damage)) {
        for (auto const& [centre, radius] : kept->place) g.add(centre, radius, density);
        return g;
    }
    std::printf("settling %zu grains (once)\n", count);
    std::fflush(stdout);
    dem::Random random(1);
    double const cell = 8.9e-3;
    auto const across = static_cast<std::size_t>(side / cell);
    double const pitch = side / static_cast<double>(across);
    for (std::size_t k = 0; k < count; ++k) {
        auto const at = [&](std::size_t n) {
            return (static_cast<double>(n) + 0.5) * pitch + random.uniform(-2e-5, 2e-5);
        };
        Vec3 const centre{at(k % across), at(k / across % across),
                          (static_cast<double>(k / across / across) + 0.5) * cell};
        g.add(centre, mean_radius * random.uniform(0.9, 1.1), density);
    }
    dem::Setup<3> s = setup_of(side);
    s.law.normal.damping = s.law.tangential.damping = 5.0;  // [N s/m], about a third of the critical one
    s.law.tangential.friction = 0.2;
    for (auto& wall : s.walls) wall.law = s.law;
    s.loads = true;
    dem::Solver<3> solver(s, g);
    int const steps = 20000 + static_cast<int>(20.0 * std::cbrt(static_cast<double>(count)));
    for (int n = 0; n < steps; ++n) {
        if (n % 10 == 0)
            for (std::size_t i = 0; i < g.size(); ++i)  // as in a thick liquid: at rest sooner
                solver.grains().external[i].force =
                    (-20.0 * solver.grains().mass[i]) * solver.grains().motion[i].velocity;
        solver.step(2.0 * step);
    }
    dem::write_packing<3>({solver.grains().place, {}, 0.0}, file);
    dem::Grains<3> rest;
    for (auto const& [centre, radius] : solver.grains().place) rest.add(centre, radius, density);
    return rest;
}

double processor_time(int who)  // s
{
    rusage usage{};
    getrusage(who, &usage);
    auto const seconds = [](timeval t) {
        return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
    };
    return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

//! One contestant: s of processor time for so many steps.
struct Contestant
{
    std::string name;
    std::function<double(int steps)> run;
    std::vector<double> rate;  //!< million grain-steps a second
};

double run_ours(dem::Solver<3> solver, int steps)
{
    for (int n = 0; n < warm_up; ++n) solver.step(step);
    double const start = processor_time(RUSAGE_SELF);
    for (int n = 0; n < steps; ++n) solver.step(step);
    return processor_time(RUSAGE_SELF) - start;
}

//! Wall time of a run by several threads [s]: processor time counts those that wait.
double run_shared(dem::Solver<3> solver, int steps)
{
    for (int n = 0; n < warm_up; ++n) solver.step(step);
    auto const start = std::chrono::steady_clock::now();
    for (int n = 0; n < steps; ++n) solver.step(step);
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

//! Of a peer's last run by two ranks: the time that it prints for its loop [s].
double printed_time(std::filesystem::path const& file)
{
    std::ifstream in(file);
    double last = 0.0;
    for (std::string line; std::getline(in, line);)
        if (line.rfind("Loop time of ", 0) == 0) {
            double const time = std::stod(line.substr(13));
            if (last == 0.0) last = time;  // the first: the second is of no steps
        }
    return last;
}

double run_ranks(std::filesystem::path const& folder, std::string const& program, int steps)
{
    std::string const command = "cd " + folder.string() + " && OMPI_ALLOW_RUN_AS_ROOT=1 " +
                                "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 mpirun -np 2 --oversubscribe " + program +
                                " -in in." + program + " -log none -var DUMP two.dump -var STEPS " +
                                std::to_string(steps) + " > out.txt 2>&1";
    if (std::system(command.c_str()) != 0) throw std::runtime_error(program + " failed, see its input there");
    return printed_time(folder / "out.txt");
}

double run_peer(std::filesystem::path const& folder, std::string const& program, int steps)
{
    auto const once = [&](int n) {
        double const start = processor_time(RUSAGE_CHILDREN);
        std::string const command = "cd " + folder.string() + " && OMPI_ALLOW_RUN_AS_ROOT=1 " +
                                    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 " + program + " -in in." + program +
                                    " -log none -var DUMP one.dump -var STEPS " + std::to_string(n) + " > out.txt 2>&1";
        if (std::system(command.c_str()) != 0) throw std::runtime_error(program + " failed, see its input there");
        return processor_time(RUSAGE_CHILDREN) - start;
    };
    double const before = once(warm_up);
    return once(warm_up + steps) - before;
}

//! A data file of both: `type diameter density x y z`, and zero velocities.
void write_data(std::filesystem::path const& file, dem::Grains<3> const& g, double side, char const* atoms)
{
    std::ofstream out(file);
    out.precision(17);
    out << "column\n\n"
        << g.size() << " atoms\n1 atom types\n\n0 " << 4.0 * side << " xlo xhi\n0 " << side << " ylo yhi\n0 "
        << 3.0 * side << " zlo zhi\n\n"
        << atoms << "\n\n";
    for (std::size_t i = 0; i < g.size(); ++i) {
        auto const& [c, r] = g.place[i];
        out << i + 1 << " 1 " << 2.0 * r << ' ' << density << ' ' << c.x << ' ' << c.y << ' ' << c.z << '\n';
    }
}

void write_liggghts(std::filesystem::path const& folder, double side)
{
    std::ofstream in(folder / "in.liggghts");
    in.precision(17);
    std::string const model = "model hooke/stiffness tangential history rolling_friction cdt ";
    std::string const damped = "absolute_damping on tangential_damping on\n";
    in << "units si\natom_style granular\natom_modify map array\nboundary f f f\nnewton off\n"
          "communicate single vel yes\nread_data grains.data\nneighbor 0.001 bin\n"
          "neigh_modify delay 0 every 1 check yes contact_distance_factor 1.05\n";
    struct Property
    {
        char const* name;
        double value;
    };
    int n = 0;
    for (auto const& [name, value] :
         {Property{"kn", kn}, Property{"kt", kt}, Property{"gamman_abs", gamma_n}, Property{"gammat_abs", gamma_t},
          Property{"coefficientFriction", mu}, Property{"coefficientRollingFriction", mu_r}})
        in << "fix m" << n++ << " all property/global " << name << " peratomtypepair 1 " << value << '\n';
    in << "pair_style gran " << model << damped << "pair_coeff * *\nfix grav all gravity 9.81 vector 0.0 0.0 -1.0\n";
    struct Side
    {
        char const* plane;
        double at;
    };
    for (auto const& [plane, at] :
         {Side{"xplane", 0.0}, Side{"xplane", side}, Side{"yplane", 0.0}, Side{"yplane", side}, Side{"zplane", 0.0}})
        in << "fix w" << n++ << " all wall/gran " << model << "primitive type 1 " << plane << ' ' << at << ' '
           << damped;
    in << "fix integr all nve/sphere\ntimestep " << step << "\nrun ${STEPS}\ndump d all custom 1 ${DUMP} id x y z\n"
       << "dump_modify d sort id format \"%d %.17g %.17g %.17g\"\nrun 0\n";
}

//! gran/hooke/history: no rolling; its damping is per mass, here for grains of the mean size.
void write_lammps(std::filesystem::path const& folder, double side)
{
    std::ofstream in(folder / "in.lmp");
    in.precision(17);
    double const half_mass = 0.5 * density * 4.0 / 3.0 * M_PI * std::pow(mean_radius, 3);
    char law[160];
    std::snprintf(law, sizeof law, "%.10g %.17g %.10g %.10g %g 1", kn, kt, gamma_n / half_mass, gamma_t / half_mass,
                  mu);
    in << "units si\natom_style sphere\natom_modify map array\nboundary f f f\nnewton off\ncomm_modify vel yes\n"
          "read_data grains.lmp\nneighbor 0.001 bin\nneigh_modify delay 0 every 1 check yes\n"
       << "pair_style gran/hooke/history " << law << "\npair_coeff * *\nfix grav all gravity 9.81 vector 0 0 -1\n";
    char axis = 'x';
    for (auto const& planes : {std::to_string(side), std::to_string(side), std::string("NULL")}) {
        in << "fix w" << axis << " all wall/gran hooke/history " << law << ' ' << axis << "plane 0.0 " << planes
           << '\n';
        ++axis;
    }
    in << "fix integr all nve/sphere\ntimestep " << step << "\nrun ${STEPS}\n";
}

bool is_installed(std::string const& program)
{
    return std::system(("command -v " + program + " > /dev/null 2>&1").c_str()) == 0;
}

double median(std::vector<double> values)
{
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
}

//! Largest distance between our grains and LIGGGHTS' after the steps that it ran last [diameters].
double distance_to(std::filesystem::path const& dump, dem::Solver<3> solver, int steps)
{
    for (int n = 0; n < steps; ++n) solver.step(step);
    std::ifstream in(dump);
    std::string line;
    while (std::getline(in, line) && line.rfind("ITEM: ATOMS", 0) != 0) continue;
    double worst = 0.0;
    for (auto const& place : solver.grains().place) {
        long id = 0;
        Vec3 c;
        if (!(in >> id >> c.x >> c.y >> c.z)) return INFINITY;
        worst = std::max(worst, norm(c - place.centre));
    }
    return worst / (2.0 * mean_radius);
}

void column(std::size_t count, int steps, int repetitions)
{
    sluice::ScratchDirectory const folder("dem-bench");
    double const side = side_of(count);
    dem::Grains<3> const grains = settled(count);
    write_data(folder.path() / "grains.data", grains, side, "Atoms");
    write_data(folder.path() / "grains.lmp", grains, side, "Atoms # sphere");
    write_liggghts(folder.path(), side);
    write_lammps(folder.path(), side);

    dem::Setup<3> theirs = setup_of(side), plain = theirs, usual = theirs;
    plain.plain = true;
    dem::ContactConfig law;
    law.normal_stiffness = kn;
    law.tangential_stiffness = kt;
    law.damping_ratio = law.tangential_damping = 0.1;
    law.friction = mu;
    law.rolling = dem::Rolling::elastic_plastic;
    law.rolling_friction = mu_r;
    law.rolling_stiffness = 1.0;
    law.rolling_damping = 0.3;
    usual.law = dem::contact_law(law);
    for (auto& wall : usual.walls) wall.law = usual.law;
    usual.absolute_damping = false;
    usual.features = {.friction = true, .rolling = dem::Rolling::elastic_plastic};
    dem::Setup<3> booked = usual;
    booked.features.ledger = true;

    std::vector<Contestant> all;
    auto const ours = [&](char const* name, dem::Setup<3> const& setup) {
        all.push_back({name, [solver = dem::Solver<3>(setup, grains)](int n) { return run_ours(solver, n); }, {}});
    };
    ours("ours, LIGGGHTS' laws and order", theirs);
    ours("ours, the same, one pair at a time", plain);
    ours("ours, default laws, sprung rolling", usual);
    ours("ours, the same with the energy ledger", booked);
    if (is_installed("liggghts"))
        all.push_back(
            {"LIGGGHTS hooke/stiffness, cdt", [&](int n) { return run_peer(folder.path(), "liggghts", n); }, {}});
    if (is_installed("lmp"))
        all.push_back({"LAMMPS gran/hooke/history", [&](int n) { return run_peer(folder.path(), "lmp", n); }, {}});
    dem::Setup<3> two = theirs, usual_two = usual;
    two.threads = usual_two.threads = 2;
    auto const shared = [&](char const* name, dem::Setup<3> const& setup) {
        all.push_back({name, [solver = dem::Solver<3>(setup, grains)](int n) { return run_shared(solver, n); }, {}});
    };
    shared("ours on two, LIGGGHTS' laws and order", two);
    shared("ours on two, default laws, sprung rolling", usual_two);
    if (is_installed("liggghts"))
        all.push_back({"LIGGGHTS on two", [&](int n) { return run_ranks(folder.path(), "liggghts", n); }, {}});
    if (is_installed("lmp"))
        all.push_back({"LAMMPS on two", [&](int n) { return run_ranks(folder.path(), "lmp", n); }, {}});
    for (int r = 0; r < repetitions; ++r)
        for (auto& one : all) one.rate.push_back(1e-6 * static_cast<double>(count) * steps / one.run(steps));

    for (auto const& one : all) {
        auto const [low, high] = std::minmax_element(one.rate.begin(), one.rate.end());
        std::printf("%7zu grains  %-40s %7.2f (%.2f to %.2f) million grain-steps/s", count, one.name.c_str(),
                    median(one.rate), *low, *high);
        for (auto const& peer : all) {
            auto const on_two = [](Contestant const& c) { return c.name.find(" on two") != std::string::npos; };
            if (peer.name.rfind("ours", 0) == 0 || one.name.rfind("ours", 0) != 0 || on_two(one) != on_two(peer))
                continue;
            std::vector<double> ratio;  // of the same repetition
            for (std::size_t r = 0; r < one.rate.size(); ++r) ratio.push_back(one.rate[r] / peer.rate[r]);
            std::printf("  %.2f x %s", median(ratio), peer.name.substr(0, peer.name.find(' ')).c_str());
            results.push_back({{"case", std::to_string(count) + " grains, " + one.name},
                               {"metric", "speed"},
                               {"value", median(one.rate)},
                               {"unit", "million grain-steps/s"},
                               {"against", peer.name},
                               {"ratio", median(ratio)}});
        }
        std::printf("\n");
    }
    if (!is_installed("liggghts")) return;
    double const apart = distance_to(folder.path() / "one.dump", dem::Solver<3>(theirs, grains), warm_up + steps);
    std::printf("%7zu grains  largest distance to LIGGGHTS' grains after %d steps: %.2e d\n", count, warm_up + steps,
                apart);
    results.push_back({{"case", std::to_string(count) + " grains"},
                       {"metric", "distance to LIGGGHTS"},
                       {"value", apart},
                       {"unit", "d"},
                       {"against", "LIGGGHTS"},
                       {"ratio", apart}});
    std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv)
{
    std::string json;
    bool small = false, large = false;
    for (int k = 1; k < argc; ++k) {
        std::string const option = argv[k];
        small = small || option == "--small";
        large = large || option == "--large";
        if (option == "--json" && k + 1 < argc) json = argv[++k];
    }
    try {
        if (small) {
            column(300, 3000, 1);
        } else {
            column(2500, 2000, 5);
            column(20000, 250, 5);
            if (large) column(100000, 50, 5);
        }
    } catch (std::exception const& e) {
        std::fprintf(stderr, "%s\n", e.what());
        return 1;
    }
    if (!json.empty()) std::ofstream(json) << results.dump(2) << '\n';
}
