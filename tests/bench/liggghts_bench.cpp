//! What coupling costs a LIGGGHTS of 20 000 spheres: all that its participant does beside LIGGGHTS' own steps, against
//! those. The spheres stand in a box, pressed and moving; the partner has a load for each of them in every window.
//! Prints a table; `--json FILE` writes a list of {case, metric, value, unit, against, ratio}. `--small`: a smoke run.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "coupler/base/scratch_directory.hpp"
#include "coupler/coupler.hpp"
#include "participants/dem/random.hpp"

namespace {

namespace fs = std::filesystem;

constexpr double goal = 0.05;     // of LIGGGHTS' own steps
constexpr double step = 5e-6;     // s
constexpr double pitch = 8.2e-3;  // m; below the mean diameter of those that are above it

//! The partner: a force against the motion, as drag.
void drag(sluice::Participant& self)
{
    self.sends({"load"});
    self.takes({"kinematics"});
    self.config().finish();
    if (self.checking()) return;
    auto const grains = self.receivers("load").at(0);
    std::vector<double> force, torque;
    self.write(grains, sluice::Load{});
    for (sluice::Window const& window : self.windows()) {
        auto sampled = self.read<sluice::Kinematics>(grains, window);
        auto const now = sampled.at(window.end);
        force.assign(now.velocity.begin(), now.velocity.end());
        torque.assign(now.angular_velocity.begin(), now.angular_velocity.end());
        for (double& f : force) f *= -1e-3;
        for (double& t : torque) t *= -1e-9;
        self.write(grains, sluice::Load{now.id, force, torque});
    }
}

//! A dense lattice of spheres of 8 mm +- 10 %, as tests/verification/dem/liggghts_test.cpp has.
void write_grains(fs::path const& file, int across, int layers)
{
    dem::Random random(11);
    std::ofstream out(file);
    out.precision(17);
    out << "x,y,z,radius,vx,vy,vz\n";
    for (int k = 0; k < across * across * layers; ++k) {
        auto const about = [&](double scale) { return random.uniform(-scale, scale); };
        out << (k % across + 0.5) * pitch + about(2e-4) << ',' << (k / across % across + 0.5) * pitch + about(2e-4)
            << ',' << (k / across / across + 0.5) * pitch + about(2e-4) << ',' << 4e-3 * random.uniform(0.9, 1.1) << ','
            << about(0.1) << ',' << about(0.1) << ',' << about(0.1) << '\n';
    }
}

void write_scene(fs::path const& file, std::string const& own, double side, int steps, int windows, char const* sample)
{
    auto const number = [](double x) {
        char text[32];
        std::snprintf(text, sizeof text, "%.9g", x);
        return std::string(text);
    };
    double const window = steps * step;
    std::ofstream(file)
        << "sluice: 1\ndimension: 3\ngravity: [0, 0, -9.81]\ntime: {end: " << number(windows * window)
        << ", window: " << number(window)
        << "}\nparticipants:\n  grains:\n    solver: liggghts\n    config:\n      density: 2650\n"
           "      contact: {normal_stiffness: 1e5, damping_ratio: 0.1, friction: 0.5}\n"
           "      packing: {file: grains.csv, velocities: kept}\n      measures: [run_out]\n      step: "
        << number(step * 1.0001) << "\n      walls:\n";
    char const* const normals[] = {"0, 0, 1", "1, 0, 0", "0, 1, 0", "-1, 0, 0", "0, -1, 0"};
    for (int w = 0; w < 5; ++w)
        std::ofstream(file, std::ios::app)
            << "        - {name: w" << w << ", point: [" << (w == 3 ? number(side) : "0") << ", "
            << (w == 4 ? number(side) : "0") << ", 0], normal: [" << normals[w] << "]}\n";
    std::ofstream(file, std::ios::app) << "  fluid: {command: [" << own
                                       << "], config: {}}\ncouplings:\n"
                                          "  - {from: grains, to: fluid, data: kinematics}\n"
                                          "  - {from: fluid, to: grains, data: load, lag: 1, predict: linear, sample: "
                                       << sample << "}\n";
}

struct Cost
{
    double own, coupling;  //!< of a step [s]
};

//! What a run of so many windows takes [s]: in LIGGGHTS' own steps, and in all the rest, without waiting.
Cost run(fs::path const& folder)
{
    std::string const command = std::string(SLUICE_COMMAND) + " run " + (folder / "scene.yaml").string() + " --out " +
                                (folder / "run").string() + " --no-report --quiet > " + (folder / "output").string() +
                                " 2>&1";
    if (std::system(command.c_str()) != 0) {
        std::ifstream output(folder / "output");
        std::fprintf(stderr, "%s", std::string(std::istreambuf_iterator<char>(output), {}).c_str());
        std::exit(1);
    }
    auto const summary = nlohmann::json::parse(std::ifstream(folder / "run/summary.json"));
    for (auto const& p : summary.at("participants"))
        if (p.at("name") == "grains") {
            double const own = p.at("facts").at("in LIGGGHTS' own steps [s]").get<double>();
            return {own, p.at("compute_seconds").get<double>() + p.at("exchange_seconds").get<double>() - own};
        }
    std::exit(1);
}

//! Of a step, without what a run does once: the difference of a long run and a short one.
template <class WriteScene>
Cost measure(fs::path const& folder, int steps, int windows, WriteScene&& write)
{
    write(windows);
    Cost const brief = run(folder);
    write(3 * windows);
    Cost const lengthy = run(folder);
    double const of = 1.0 / (2.0 * steps * windows);
    return {of * (lengthy.own - brief.own), of * (lengthy.coupling - brief.coupling)};
}

double median(std::vector<double> values)
{
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
}

int bench(int argc, char** argv)
{
    bool small = false;
    std::string json;
    for (int k = 1; k < argc; ++k)
        if (std::string(argv[k]) == "--small")
            small = true;
        else if (std::string(argv[k]) == "--json" && k + 1 < argc)
            json = argv[++k];
    int const across = small ? 8 : 20, layers = small ? 5 : 50, repetitions = small ? 1 : 5;
    sluice::ScratchDirectory const folder("sluice-bench");
    write_grains(folder.path() / "grains.csv", across, layers);
    nlohmann::json results = nlohmann::json::array();
    std::printf("%d spheres; times of a step, median of %d [us]\n%-44s %10s %10s %8s\n", across * across * layers,
                repetitions, "", "LIGGGHTS", "coupling", "share");
    for (auto const& [steps, sample] : {std::pair{1, "hold"}, {10, "hold"}, {10, "linear"}, {20, "hold"}}) {
        int const windows = small ? 2 : std::max(4, 60 / steps);
        auto const write = [&](int count) {
            write_scene(folder.path() / "scene.yaml", fs::absolute(argv[0]).string(), across * pitch, steps, count,
                        sample);
        };
        std::vector<double> own, coupling, share;
        for (int k = 0; k < repetitions; ++k) {
            auto const cost = measure(folder.path(), steps, windows, write);
            own.push_back(cost.own);
            coupling.push_back(cost.coupling);
            share.push_back(cost.coupling / cost.own);
        }
        std::string const name = std::to_string(steps) + (steps == 1 ? " step" : " steps") + " a window, loads " +
                                 (steps == 1                      ? "once"
                                  : std::string(sample) == "hold" ? "that stay"
                                                                  : "in every step");
        std::printf("%-44s %10.1f %10.1f %7.1f%%\n", name.c_str(), 1e6 * median(own), 1e6 * median(coupling),
                    100.0 * median(share));
        results.push_back({{"case", "liggghts"},
                           {"metric", name + ": coupling over LIGGGHTS' own step"},
                           {"value", median(share)},
                           {"unit", ""},
                           {"against", goal},
                           {"ratio", median(share) / goal}});
    }
    if (!json.empty()) std::ofstream(json) << results.dump(1) << '\n';
    return 0;
}

}  // namespace

int main(int argc, char** argv)
{
    for (int k = 1; k < argc; ++k)
        if (std::string(argv[k]) == "--as") return sluice::run(argc, argv, drag);
    return bench(argc, argv);
}
