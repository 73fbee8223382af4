#include "coupler/work.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "coupler/places.hpp"

namespace sluice {
namespace {

constexpr std::size_t block = 512;  // numbers that are summed up at a time: two such arrays stay in the first cache

//! A column of several parts at the same points: where each stands, and its weight.
struct Aligned
{
    std::vector<double const*> values;
    std::vector<double> weights;
    std::vector<std::vector<double>> own;  //!< of parts whose points stand in another order
};

//! For each part the places of `ids` in it; empty: the same points in the same order.
std::vector<std::vector<std::size_t>> places_in(std::span<std::int64_t const> ids, std::span<FramePart const> parts)
{
    std::vector<std::vector<std::size_t>> places(parts.size());
    for (std::size_t p = 0; p < parts.size(); ++p)
        if (!same_ids(ids, parts[p].points.ids)) places[p] = places_of(ids, parts[p].points.ids);
    return places;
}

Aligned align(std::span<std::int64_t const> ids, std::span<FramePart const> parts, std::size_t column,
              std::size_t width)
{
    auto const places = places_in(ids, parts);
    auto const at = [&](std::size_t p, std::size_t i) { return places[p].empty() ? i : places[p][i]; };
    Aligned result;
    for (std::size_t p = 0; p < parts.size(); ++p) {
        result.weights.push_back(parts[p].weight);
        if (places[p].empty()) {
            result.values.push_back(parts[p].points.columns[column].data());
            continue;
        }
        std::vector<double> values(ids.size() * width);
        for (std::size_t i = 0; i < ids.size(); ++i) {
            std::size_t from = p;
            if (at(p, i) == nowhere)
                for (from = 0; from < parts.size() && at(from, i) == nowhere;) ++from;
            if (from < parts.size())
                std::copy_n(parts[from].points.columns[column].data() + at(from, i) * width, width,
                            values.data() + i * width);
        }
        result.own.push_back(std::move(values));
        result.values.push_back(result.own.back().data());
    }
    return result;
}

//! `count` numbers from `begin` on: where they stand, or summed up in `room`.
double const* sum_of(Aligned const& parts, std::size_t begin, std::size_t count, double* room)
{
    if (parts.values.size() == 1 && parts.weights[0] == 1.0) return parts.values[0] + begin;
    for (std::size_t p = 0; p < parts.values.size(); ++p) {
        double const* const from = parts.values[p] + begin;
        double const weight = parts.weights[p];
        for (std::size_t k = 0; k < count; ++k) room[k] = (p == 0 ? 0.0 : room[k]) + weight * from[k];
    }
    return room;
}

}  // namespace

std::vector<PowerPair> power_pairs(DataSpec const& load, DataSpec const& motion, int dimension)
{
    std::vector<PowerPair> pairs;
    if (load.meshless || motion.meshless) return pairs;
    for (std::size_t l = 0; l < load.columns.size(); ++l) {
        auto const& unit = load.columns[l].unit;
        if (unit != "N" && unit != "N m") continue;
        int const width = components(load.columns[l].shape, dimension);
        for (std::size_t m = 0; m < motion.columns.size(); ++m) {
            if (motion.columns[m].unit != (unit == "N" ? "m/s" : "rad/s")) continue;
            if (components(motion.columns[m].shape, dimension) != width) continue;
            pairs.push_back(
                {l, m, static_cast<std::size_t>(width), load.columns[l].name + " x " + motion.columns[m].name});
            break;
        }
    }
    return pairs;
}

int motion_edge(Scene const& scene, int load)
{
    auto const data = [&](Edge const& e) -> DataSpec const& { return scene.data[static_cast<std::size_t>(e.data)]; };
    Edge const& edge = scene.edges[static_cast<std::size_t>(load)];
    if (!data(edge).additive && scene.participants[static_cast<std::size_t>(edge.from)].ranks > 1) return -1;
    for (std::size_t e = 0; e < scene.edges.size(); ++e) {
        Edge const& back = scene.edges[e];
        if (back.from == edge.to && back.to == edge.from &&
            !power_pairs(data(edge), data(back), scene.dimension).empty())
            return static_cast<int>(e);
    }
    return -1;
}

PointsView view_of(Frame const& frame)
{
    PointsView view{frame.ids.values, {}};
    for (auto const& column : frame.columns) view.columns.push_back(column.values);
    return view;
}

void remember(std::deque<KeptPoints>& kept, std::int64_t index, std::span<std::int64_t const> ids,
              std::span<std::span<double const> const> values, std::vector<char> const& wanted)
{
    if (kept.empty() || kept.front().index != index) {
        if (kept.size() < 2) kept.emplace_back();
        std::rotate(kept.begin(), kept.end() - 1, kept.end());  // the oldest one's memory is used again
    }
    KeptPoints& to = kept.front();
    to.index = index;
    to.ids.assign(ids.begin(), ids.end());
    to.columns.resize(values.size());
    for (std::size_t c = 0; c < values.size(); ++c)
        if (wanted[c]) to.columns[c].assign(values[c].begin(), values[c].end());
}

KeptPoints const* kept_frame(std::deque<KeptPoints> const& kept, std::int64_t index)
{
    for (auto const& points : kept)
        if (points.index == index) return &points;
    return nullptr;
}

Power power_of(std::size_t load, std::size_t motion, std::size_t width, std::span<FramePart const> loads,
               std::span<FramePart const> motions)
{
    auto const& ids = loads[0].points.ids;
    auto const force = align(ids, loads, load, width), velocity = align(ids, motions, motion, width);
    std::array<double, block> force_room, velocity_room;
    std::array<double, 4> net{}, moved{};  // four sums: each addition would wait for the one before
    std::size_t const all = ids.size() * width;
    for (std::size_t begin = 0; begin < all; begin += block) {
        auto const count = std::min(block, all - begin);
        double const* const f = sum_of(force, begin, count, force_room.data());
        double const* const v = sum_of(velocity, begin, count, velocity_room.data());
        std::size_t k = 0;
        for (; k + 4 <= count; k += 4)
            for (std::size_t lane = 0; lane < 4; ++lane) {
                double const product = f[k + lane] * v[k + lane];
                net[lane] += product;
                moved[lane] += std::abs(product);
            }
        for (; k < count; ++k) {
            net[0] += f[k] * v[k];
            moved[0] += std::abs(f[k] * v[k]);
        }
    }
    return {net[0] + net[1] + (net[2] + net[3]), moved[0] + moved[1] + (moved[2] + moved[3])};
}

void Tally::restart()
{
    samples = 0;
    weights = {};
    whole.clear();
}

void Tally::add(Frame const& newest, std::vector<std::span<double const>> const& values,
                std::array<double, 3> const& by)
{
    if (samples++ == 0) {
        ids = newest.ids;
        if (by[0] == 1.0 && by[1] == 0.0 && by[2] == 0.0) whole = newest.columns;
    }
    for (std::size_t k = 0; k < by.size(); ++k) weights[k] += by[k];
    if (samples == 1 && !whole.empty()) return;
    sums.resize(values.size());
    for (std::size_t c = 0; c < values.size(); ++c) {
        if (!columns[c]) continue;
        if (samples == 1)
            sums[c].assign(values[c].begin(), values[c].end());
        else if (!whole.empty())
            sums[c].assign(whole[c].values.begin(), whole[c].values.end());
        if (samples == 1) continue;
        double* const to = sums[c].data();
        double const* const from = values[c].data();
        for (std::size_t k = 0; k < values[c].size(); ++k) to[k] += from[k];
    }
    whole.clear();
}

FramePart Tally::mean() const
{
    FramePart part{{ids.values, {}}, 1.0 / samples};
    if (whole.empty()) part.points.columns.assign(sums.begin(), sums.end());
    for (auto const& column : whole) part.points.columns.push_back(column.values);
    return part;
}

std::vector<double> SaidPower::numbers() const
{
    auto all = of_frame;
    all.insert(all.end(), of_window.begin(), of_window.end());
    return all;
}

std::optional<SaidPower> SaidPower::from(std::span<double const> numbers, std::size_t pairs)
{
    if (numbers.size() != 2 * pairs) return std::nullopt;
    auto const middle = numbers.begin() + static_cast<std::ptrdiff_t>(pairs);
    return SaidPower{.of_frame = {numbers.begin(), middle}, .of_window = {middle, numbers.end()}};
}

}  // namespace sluice
