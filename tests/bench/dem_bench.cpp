//! Speed of spheres in a dense settled column beside the real LIGGGHTS and LAMMPS (Debian's packages; without them
//! their lines are left out): the same grains, walls, step and, for LIGGGHTS, the same laws. Prints a table; `--json
//! FILE` writes a list of {case, metric, value, unit, against, ratio}; `--small`: a smoke run; `--large`: 100 000
//! grains, and a collapse by the step, too. Times are processor time, a peer's by the difference of a long and a short
//! run: other work on the machine then counts less; on two cores it is the wall's. All run one after another in each
//! repetition; the table has the medians.
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include "coupler/base/scratch_directory.hpp"
#include "participants/dem/config.hpp"
#include "participants/dem/grain_file.hpp"
#include "participants/dem/measures.hpp"
#include "participants/dem/random.hpp"
#include "participants/dem/setup.hpp"
#include "participants/dem/solver.hpp"
#include "tests/bench/dem_column.hpp"
#include "tests/support/liggghts_column.hpp"

namespace {

using dem::Vec3;
using namespace dem_bench;

using liggghts::density, liggghts::step, liggghts::kn, liggghts::kt, liggghts::mu, liggghts::mu_r;
//! One contestant: s of processor time for so many steps.
struct Contestant
{
    std::string name;
    std::function<double(int steps)> run;
    std::vector<double> rate;  //!< million grain-steps a second
};

//! Runs a peer once; `before` stands before its name. LIGGGHTS leaves its grains in `dump`.
void start_peer(std::filesystem::path const& folder, std::string const& before, std::string const& program,
                std::string const& dump, int steps)
{
    std::string const command = "cd " + folder.string() + " && OMPI_ALLOW_RUN_AS_ROOT=1 " +
                                "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 " + before + program + " -in in." + program +
                                " -log none -var DUMP " + dump + " -var STEPS " + std::to_string(steps) +
                                " > out.txt 2>&1";
    if (std::system(command.c_str()) != 0) throw std::runtime_error(program + " failed, see its input there");
}

double run_peer(std::filesystem::path const& folder, std::string const& program, int steps)
{
    auto const once = [&](int n) {
        double const start = processor_time(RUSAGE_CHILDREN);
        start_peer(folder, "", program, "one.dump", n);
        return processor_time(RUSAGE_CHILDREN) - start;
    };
    double const before = once(warm_up);
    return once(warm_up + steps) - before;
}

//! By two ranks: the wall time that the peer prints for its loop, the first of the file [s].
double run_ranks(std::filesystem::path const& folder, std::string const& program, int steps)
{
    start_peer(folder, "mpirun -np 2 --oversubscribe ", program, "two.dump", steps);
    std::ifstream in(folder / "out.txt");
    for (std::string line; std::getline(in, line);)
        if (line.rfind("Loop time of ", 0) == 0) return std::stod(line.substr(13));
    throw std::runtime_error(program + " printed no time of its loop");
}

void write_liggghts(std::filesystem::path const& folder, double side)
{
    std::ofstream(folder / "in.liggghts")
        << liggghts::commands("grains.data", side) << "run ${STEPS}\ndump d all custom 1 ${DUMP} id x y z\n"
        << "dump_modify d sort id format \"%d %.17g %.17g %.17g\"\nrun 0\n";
}

//! gran/hooke/history: no rolling; its damping is per mass, here for grains of the mean size.
void write_lammps(std::filesystem::path const& folder, double side)
{
    std::ofstream in(folder / "in.lmp");
    in.precision(17);
    double const half_mass = 0.5 * density * 4.0 / 3.0 * M_PI * std::pow(mean_radius, 3);
    char law[160];
    std::snprintf(law, sizeof law, "%.10g %.17g %.10g %.10g %g 1", kn, kt, liggghts::gamma_n / half_mass,
                  liggghts::gamma_t / half_mass, mu);
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

//! The same grains sorted in space, as those of a scene are, or in a random order, as a code's output file has them
//! after a while.
dem::Grains<3> arranged(dem::Grains<3> const& g, bool sorted)
{
    dem::Config config;
    config.density = density;
    for (auto const& [centre, radius] : g.place) {
        dem::GrainConfig grain{};
        grain.position = centre;
        grain.radius = radius;
        config.grains.push_back(grain);
    }
    dem::Random random(5);
    if (sorted)
        dem::sort_in_space(config.grains);
    else
        for (std::size_t k = g.size() - 1; k > 0; --k)
            std::swap(config.grains[k], config.grains[random.next() % (k + 1)]);
    return dem::listed_grains<3>(config);
}

//! Largest distance between our grains and LIGGGHTS' after the steps that it ran last [diameters].
double distance_to(std::filesystem::path const& dump, dem::Solver<3> solver, int steps)
{
    solver.steps(step, steps);
    auto const& place = solver.grains().place;
    auto const theirs = liggghts::last_of_dump(dump, place.size(), 3);
    if (theirs.empty()) return INFINITY;
    double worst = 0.0;
    for (std::size_t i = 0; i < place.size(); ++i)
        worst = std::max(worst, norm(place[i].centre - Vec3{theirs[i][0], theirs[i][1], theirs[i][2]}));
    return worst / (2.0 * mean_radius);
}

void column(std::size_t count, int steps, int repetitions)
{
    sluice::ScratchDirectory const folder("dem-bench");
    double const side = side_of(count);
    dem::Grains<3> const grains = arranged(settled(count), true);
    liggghts::write_data(folder.path() / "grains.data", grains, side, "Atoms");
    liggghts::write_data(folder.path() / "grains.lmp", grains, side, "Atoms # sphere");
    write_liggghts(folder.path(), side);
    write_lammps(folder.path(), side);

    dem::Setup<3> theirs = liggghts::setup(side), plain = theirs, usual = theirs;
    plain.plain = true;
    usual.law = dem::contact_law(laws(dem::Rolling::elastic_plastic));
    for (auto& wall : usual.walls) wall.law = usual.law;
    usual.absolute_damping = false;
    usual.features = {.friction = true, .rolling = dem::Rolling::elastic_plastic};
    dem::Setup<3> booked = usual;
    booked.features.ledger = true;
    dem::Solver<3> const rest(theirs, grains);
    auto const a_grain = [&](double number) { return number / static_cast<double>(count); };
    std::printf("%7zu grains  at rest: %.2f contacts and %.2f listed pairs a grain\n", count,
                a_grain(static_cast<double>(dem::measure(rest).contacts)),
                a_grain(static_cast<double>(rest.state().pairs.other.size())));

    std::vector<Contestant> all;
    auto const ours = [&](char const* name, dem::Setup<3> const& setup, double (*clock)() = own_time) {
        all.push_back(
            {name, [clock, solver = dem::Solver<3>(setup, grains)](int n) { return run_ours(solver, n, clock); }, {}});
    };
    ours("ours, LIGGGHTS' laws and order", theirs);
    ours("ours, the same, one pair at a time", plain);
    ours("ours, default laws, sprung rolling", usual);
    ours("ours, the same with the energy ledger", booked);
    all.push_back(
        {"ours, grains in no order",
         [solver = dem::Solver<3>(theirs, arranged(grains, false))](int n) { return run_ours(solver, n, own_time); },
         {}});
    if (is_installed("liggghts"))
        all.push_back(
            {"LIGGGHTS hooke/stiffness, cdt", [&](int n) { return run_peer(folder.path(), "liggghts", n); }, {}});
    if (is_installed("lmp"))
        all.push_back({"LAMMPS gran/hooke/history", [&](int n) { return run_peer(folder.path(), "lmp", n); }, {}});
    dem::Setup<3> two = theirs, usual_two = usual;
    two.threads = usual_two.threads = 2;
    ours("ours on two, LIGGGHTS' laws and order", two, wall_time);
    ours("ours on two, default laws, sprung rolling", usual_two, wall_time);
    if (is_installed("liggghts"))
        all.push_back({"LIGGGHTS on two", [&](int n) { return run_ranks(folder.path(), "liggghts", n); }, {}});
    if (is_installed("lmp"))
        all.push_back({"LAMMPS on two", [&](int n) { return run_ranks(folder.path(), "lmp", n); }, {}});
    for (int r = 0; r < repetitions; ++r)
        for (auto& one : all) one.rate.push_back(1e-6 * static_cast<double>(count) * steps / one.run(steps));

    for (auto const& one : all) {
        auto const [low, high] = std::minmax_element(one.rate.begin(), one.rate.end());
        std::printf("%7zu grains  %-48s %7.2f (%.2f to %.2f) million grain-steps/s", count, one.name.c_str(),
                    median(one.rate), *low, *high);
        for (auto const& peer : all) {
            auto const on_two = [](Contestant const& c) { return c.name.find(" on two") != std::string::npos; };
            if (peer.name.rfind("ours", 0) == 0 || one.name.rfind("ours", 0) != 0 || on_two(one) != on_two(peer))
                continue;
            std::vector<double> ratio;  // of the same repetition
            for (std::size_t r = 0; r < one.rate.size(); ++r) ratio.push_back(one.rate[r] / peer.rate[r]);
            std::printf("  %.2f x %s", median(ratio), peer.name.substr(0, peer.name.find(' ')).c_str());
            note(std::to_string(count) + " grains, " + one.name, "speed", median(one.rate), "million grain-steps/s",
                 peer.name.c_str(), median(ratio));
        }
        std::printf("\n");
    }
    if (!is_installed("liggghts")) return;
    double const apart = distance_to(folder.path() / "one.dump", dem::Solver<3>(theirs, grains), warm_up + steps);
    std::printf("%7zu grains  largest distance to LIGGGHTS' grains after %d steps: %.2e d\n", count, warm_up + steps,
                apart);
    note(std::to_string(count) + " grains", "distance to LIGGGHTS", apart, "d", "LIGGGHTS", apart);
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
            features(300, 300, 1);
            impact_errors();
        } else {
            column(2500, 2000, 5);
            features(2500, 1000, 5);
            column(20000, 250, 5);
            impact_errors();
            if (large) {
                column(100000, 50, 5);
                run_out_errors();
            }
        }
    } catch (std::exception const& e) {
        std::fprintf(stderr, "%s\n", e.what());
        return 1;
    }
    if (!json.empty()) std::ofstream(json) << results.dump(2) << '\n';
}
