#include "tests/simulation/topology.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "tests/simulation/random.hpp"

namespace simulation {
namespace {

char const* const names[] = {"ant", "bee", "cat", "dog"};

//! One coupling at most each way between two; those with lag 0 follow the numbers, so that there is no circle of them.
std::string couplings(Random& random, int n, bool grouped)
{
    std::string text;
    for (int p = 0; p < n; ++p)
        for (int q = p + 1; q < n; ++q) {
            bool const together = grouped && q == 1;  // 0 and 1 are the group
            bool const must = together || q == p + 1;
            std::int64_t const ways = must ? random.between(1, 3) : random.below(4);
            for (int back = 0; back < 2; ++back) {
                if (!together && !(ways & (1 << back))) continue;
                bool const lagged = back == 1 || random.one_in(2);
                text += fmt::format("  - {{from: {}, to: {}, data: place, lag: {}", names[back ? q : p],
                                    names[back ? p : q], lagged ? 1 : 0);
                if (lagged && random.one_in(2)) text += random.one_in(2) ? ", predict: linear" : ", predict: quadratic";
                if (random.one_in(3)) text += ", sample: hold";
                text += "}\n";
            }
        }
    return text;
}

}  // namespace

Topology::Topology(std::uint64_t seed)
{
    Random random(seed);
    int const n = static_cast<int>(random.one_in(4) ? 4 : random.between(2, 3));
    bool const grouped = random.one_in(5);
    windows = random.between(1, grouped ? 4 : 7);
    adaptive = random.one_in(3);
    if (random.one_in(4)) early = random.below(windows);
    settles = random.one_in(3);
    if (grouped) tolerance = 1e-4;
    int left = 5;  // processes
    std::string participants;
    for (int p = 0; p < n; ++p) {
        Part part;
        int const most = std::min(3, left - (n - p - 1));
        if (!grouped && random.one_in(3)) part.ranks = static_cast<int>(random.between(1, most));
        left -= part.ranks;
        part.points = static_cast<int>(random.between(1, 4));
        part.moves = random.one_in(2);
        part.changes = !(grouped && p < 2) && random.one_in(3);
        if (random.one_in(3)) part.step = adaptive ? 0.25 : 0.125;
        parts.push_back(part);
        participants += fmt::format("{}{}: {{command: none, ranks: {}}}", p ? ", " : "", names[p], part.ranks);
    }
    parts[0].step = 0.25;
    auto const pacer = names[random.below(n)];
    text = fmt::format(
        "sluice: 1\ntime: {{end: {}, window: {}, pace: {}}}\ntimeouts: {{connect: 1, silence: 0.5}}\n"
        "data: {{place: {{columns: {{place: {{unit: m}}, mark: {{unit: m}}}}}}}}\nparticipants: {{{}}}\n"
        "couplings:\n{}",
        0.25 * static_cast<double>(windows), random.one_in(2) ? "auto" : "0.25", pacer, participants,
        couplings(random, n, grouped));
    if (grouped)
        text += fmt::format("implicit: [{{participants: [ant, bee], method: {}, tolerance: 1e-7}}]\n",
                            random.one_in(2) ? "iqn-ils" : "aitken");
    auto loaded = std::make_shared<sluice::LoadedScene>(sluice::load_scene_text(text, "scene.yaml"));
    if (!loaded->diagnostics->problems.empty())
        throw std::logic_error(text + "\n" + loaded->diagnostics->problems.front().text);
    scene = std::move(loaded);
}

double Topology::value(int p, std::int64_t i, double t) const
{
    auto const point = static_cast<double>(i);
    return 1 + p + 0.25 * point + (2 + 0.5 * p + 0.125 * point) * t;
}

bool Topology::has(int p, int rank, std::int64_t i, std::int64_t frame) const
{
    auto const& part = parts[static_cast<std::size_t>(p)];
    if (part.changes && (i + frame) % 3 == 0) return false;
    return (i + (part.moves ? frame : 0)) % part.ranks == rank;
}

std::vector<std::int64_t> Topology::points(int p, int rank, std::int64_t frame) const
{
    auto const& part = parts[static_cast<std::size_t>(p)];
    std::vector<std::int64_t> ids;
    for (std::int64_t k = 0; k < part.points; ++k) {
        auto const i = (k + (part.changes ? frame : 0)) % part.points;
        if (has(p, rank, i, frame)) ids.push_back(i);
    }
    return ids;
}

sluice::Edge const* Topology::edge(int from, int to) const
{
    for (auto const& e : scene->scene.edges)
        if (e.from == from && e.to == to) return &e;
    return nullptr;
}

//! A receiver of several processes gets each point where it came from, as far as something comes back; else everywhere.
bool Topology::sends(int p, int from, int q, int to, std::int64_t i, std::int64_t frame) const
{
    if (!has(p, from, i, frame)) return false;
    auto const* const back = edge(q, p);
    auto const ranks = parts[static_cast<std::size_t>(q)].ranks;
    if (ranks == 1 || !back || frame == 0) return true;
    for (int r = 0; r < ranks; ++r)
        if (i < parts[static_cast<std::size_t>(q)].points && sends(q, r, p, from, i, frame - back->lag)) return r == to;
    return to == 0;
}

std::vector<std::int64_t> Topology::received(int p, int q, int to, std::int64_t frame) const
{
    std::vector<std::int64_t> ids;
    for (int from = 0; from < parts[static_cast<std::size_t>(p)].ranks; ++from)
        for (auto const i : points(p, from, frame))
            if (sends(p, from, q, to, i, frame)) ids.push_back(i);
    return ids;
}

int Topology::processes() const
{
    int count = 0;
    for (auto const& part : parts) count += part.ranks;
    return count;
}

bool Topology::in_group(int p) const
{
    return !scene->scene.implicit.empty() && p < 2;
}

}  // namespace simulation
