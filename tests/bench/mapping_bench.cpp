//! Speed of the mappings beside a copy of the same bytes. Prints a table; `--json FILE` writes a list of
//! {case, metric, value, unit, against, ratio}. `--small`: a smoke run. Times are processor time: there is one thread,
//! it waits for nobody, and so other work on the machine does not count.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>
#include <string>

#include "coupler/mapping/lattice_mapping.hpp"
#include "coupler/mapping/mapping.hpp"
#include "tests/support/processor_time.hpp"

namespace {

nlohmann::json results = nlohmann::json::array();

//! ratio = value / what it stands against.
void note(std::string const& name, char const* metric, double value, char const* against, double ratio)
{
    std::printf("%-40s %-24s %10.1f us %8.2f times %s\n", name.c_str(), metric, value, ratio, against);
    std::fflush(stdout);
    results.push_back(
        {{"case", name}, {"metric", metric}, {"value", value}, {"unit", "us"}, {"against", against}, {"ratio", ratio}});
}

//! Median of five [us]; each is the mean of as many calls as 10 ms hold, at most 200. One call before, to warm up.
template <class Work>
double median_time(Work&& work)
{
    auto const time = [&](int calls) {
        double const start = unit::processor_time();
        for (int i = 0; i < calls; ++i) work();
        return 1e6 * (unit::processor_time() - start) / calls;
    };
    time(1);
    int const calls = std::clamp(static_cast<int>(1e4 / time(1)), 1, 200);
    double sample[5];
    for (double& s : sample) s = time(calls);
    std::sort(sample, sample + 5);
    return sample[2];
}

//! Reads and writes `numbers` doubles once.
double copy_time(std::size_t numbers)
{
    std::vector<double> from(numbers, 1.0), to(numbers);
    return median_time([&] {
        std::memcpy(to.data(), from.data(), numbers * sizeof(double));
        from[0] = to[numbers - 1];
    });
}

std::vector<double> random_values(std::size_t count, double high)
{
    std::mt19937_64 random(count);
    std::uniform_real_distribution<double> uniform(0, high);
    std::vector<double> values(count);
    for (double& v : values) v = uniform(random);
    return values;
}

enum class Order
{
    random,    //!< no point near the one before it: the worst case for the caches
    by_layers  //!< as a solver with cell lists keeps them
};

//! Points at random in the unit box.
std::vector<double> points(int dimension, std::size_t count, Order order)
{
    auto const d = static_cast<std::size_t>(dimension);
    std::vector<double> position = random_values(count * d, 1);
    if (order == Order::random) return position;
    std::vector<std::size_t> index(count);
    for (std::size_t i = 0; i < count; ++i) index[i] = i;
    double const layers = std::pow(static_cast<double>(count), 1.0 / dimension);
    auto const key = [&](std::size_t i, std::size_t k) { return std::floor(position[i * d + k] * layers); };
    std::sort(index.begin(), index.end(), [&](std::size_t a, std::size_t b) {
        for (std::size_t k = d; k-- > 1;)
            if (key(a, k) != key(b, k)) return key(a, k) < key(b, k);
        return position[a * d] < position[b * d];
    });
    std::vector<double> sorted;
    for (std::size_t const i : index)
        for (std::size_t k = 0; k < d; ++k) sorted.push_back(position[i * d + k]);
    return sorted;
}

//! A window of moving points: places anew, three components to the points, three back into an emptied lattice.
//! As many cells as points. The copy: positions, values and both lattices' values.
void lattice_case(int dimension, sluice::LatticeKernel kernel, char const* name, std::size_t count, Order order)
{
    auto const side = static_cast<std::int64_t>(std::pow(static_cast<double>(count), 1.0 / dimension) + 0.5);
    sluice::Lattice const lattice{dimension, {}, 1.0 / static_cast<double>(side), {side, side, side}};
    sluice::LatticeMapping map(lattice, kernel);
    std::vector<double> const position = points(dimension, count, order);
    std::vector<double> const fluid = random_values(3 * lattice.size(), 1), load = random_values(3 * count, 1);
    std::vector<double> gathered(3 * count), spread(3 * lattice.size());
    double const time = median_time([&] {
        map.place(position);
        map.gather(fluid, 3, gathered);
        std::ranges::fill(spread, 0.0);
        map.spread(load, 3, spread);
    });
    double const copy = copy_time(position.size() + fluid.size() + load.size());
    std::string const title = std::string(name) + ", " + std::to_string(dimension) + "D, N = " + std::to_string(count) +
                              (order == Order::random ? ", random order" : "");
    note(title, "place, gather, spread", time, "copy of the same bytes", time / copy);
    if (count >= 1000)  // half of what a window with its exchange may take: 200, 1500, 15 000 us
        note(title, "share of target", time, "half a window's target",
             time / (count == 1000 ? 100 : 0.075 * static_cast<double>(count)));
}

//! Both ways between two random clouds of as many points, three components; the map is built anew each time.
template <class Build>
void points_case(char const* name, std::size_t count, Build&& build)
{
    std::vector<double> const from = points(3, count, Order::by_layers), to = random_values(3 * count + 3, 1);
    std::span<double const> const targets(to.data(), 3 * count);
    std::vector<double> const values = random_values(3 * count, 1);
    std::vector<double> there(3 * count), back(3 * count);
    double const copy = copy_time(4 * 3 * count);
    std::string const title = std::string(name) + ", 3D, N = " + std::to_string(count);
    double const building = median_time([&] { build(sluice::Points{from, 3}, sluice::Points{targets, 3}); });
    note(title, "build", building, "copy of the same bytes", building / copy);
    sluice::Mapping const map = build(sluice::Points{from, 3}, sluice::Points{targets, 3});
    double const applying = median_time([&] {
        map.consistent(values, 3, there);
        map.conservative(values, 3, back);
    });
    note(title, "apply both ways", applying, "copy of the same bytes", applying / copy);
}

}  // namespace

int main(int argc, char** argv)
{
    using sluice::LatticeKernel, sluice::Points;
    std::vector<std::size_t> counts = {1000, 10'000, 100'000};
    std::size_t most = 10'000;
    char const* json = nullptr;
    for (int i = 1; i < argc; ++i) {
        if (std::strcmp(argv[i], "--small") == 0) counts = {200}, most = 200;
        if (std::strcmp(argv[i], "--json") == 0 && i + 1 < argc) json = argv[++i];
    }
    for (std::size_t const count : counts) {
        for (int const d : {2, 3}) {
            lattice_case(d, LatticeKernel::hat, "hat", count, Order::by_layers);
            lattice_case(d, LatticeKernel::three_point, "three_point", count, Order::by_layers);
            lattice_case(d, LatticeKernel::four_point, "four_point", count, Order::by_layers);
        }
        lattice_case(3, LatticeKernel::four_point, "four_point", count, Order::random);
        points_case("nearest", count, [](Points a, Points b) { return sluice::map_nearest(a, b); });
        if (count > most) continue;  // tenths of a second and more: nothing for every window
        double const radius = 1.5 * std::cbrt(1.0 / static_cast<double>(count));
        points_case("kernel", count, [&](Points a, Points b) { return sluice::map_kernel(a, b, radius); });
        points_case("linear", count, [](Points a, Points b) { return sluice::map_linear(a, b); });
        points_case("rbf", count, [](Points a, Points b) { return sluice::map_rbf(a, b); });
    }
    if (json) std::ofstream(json) << results.dump(1) << '\n';
}
