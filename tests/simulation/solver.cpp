#include "tests/simulation/solver.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>

namespace simulation {
namespace {

class Solver
{
 public:
    Solver(sluice::Participant& self, Topology const& topology, int p, Record& record)
        : self_(self), topology_(topology), p_(p), record_(record)
    {}

    void tell(std::int64_t frame, double t)
    {
        auto const ids = topology_.points(p_, self_.rank(), frame);
        std::vector<double> place, mark;
        for (auto const i : ids) {
            place.push_back(topology_.value(p_, i, t) + correction_);
            mark.push_back(static_cast<double>(i + 100 * p_));
            note(std::bit_cast<std::uint64_t>(place.back()));
        }
        for (auto const& to : self_.receivers("place")) self_.write(to, "place", ids, {place, mark});
    }

    //! All that comes in, at several times of the window. Inside a group what others lack is corrected for.
    void take(sluice::Window const& window)
    {
        correction_ = 0;
        note(static_cast<std::uint64_t>(window.index) << 8 | static_cast<std::uint64_t>(window.iteration));
        for (auto const& edge : self_.scene().edges) {
            if (edge.to != p_) continue;
            bool const inside = topology_.in_group(p_) && topology_.in_group(edge.from);
            auto samples =
                self_.read(self_.scene().participants[static_cast<std::size_t>(edge.from)].name, "place", window);
            auto const frame = window.index + 1 - edge.lag;
            auto const expected = topology_.received(edge.from, p_, self_.rank(), frame);
            if (!std::ranges::equal(samples.ids(), expected)) {
                say(window, "other points than were sent");
                continue;
            }
            for (double const s : {0.0, 0.375, 1.0}) {
                double const t = s == 0 ? window.begin : s == 1 ? window.end : window.begin + s * window.length;
                auto const& columns = samples.columns(t);
                for (std::size_t k = 0; k < expected.size(); ++k) {
                    double const place = columns[0][k];
                    note(std::bit_cast<std::uint64_t>(place));
                    auto const right = exact(edge, inside, window, frame, expected[k], s);
                    if (right && !(std::abs(place - *right) < topology_.tolerance))
                        say(window,
                            fmt::format("{} of point {} at s = {} where {} was sent", place, expected[k], s, *right));
                    double const mark = static_cast<double>(expected[k] + 100 * edge.from);
                    if (!(std::abs(columns[1][k] - mark) <= topology_.tolerance * mark))
                        say(window, "a number that never changes has changed");
                    if (inside && s == 1.0)
                        correction_ += 0.2 * (place - topology_.value(edge.from, expected[k], window.end)) /
                                       static_cast<double>(expected.size());
                }
            }
        }
    }

    void note(std::uint64_t x)
    {
        record_.states = (record_.states ^ x) * 0x9e3779b97f4a7c15;
        record_.states ^= record_.states >> 29;
    }

 private:
    //! What a sample must be, where it is known: from the line that the sender follows.
    std::optional<double> exact(sluice::Edge const& edge, bool inside, sluice::Window const& window, std::int64_t frame,
                                std::int64_t i, double s) const
    {
        bool const hold = edge.sample == sluice::Sampling::hold;
        double const share = hold ? 1.0 : s;
        double const t = share == 0 ? window.begin : share == 1 ? window.end : window.begin + share * window.length;
        auto const known = [&](std::int64_t f) {
            if (f < 0) return false;
            auto const ids = topology_.received(edge.from, p_, self_.rank(), f);
            return std::find(ids.begin(), ids.end(), i) != ids.end();
        };
        if (inside) return share == 0 ? std::optional(topology_.value(edge.from, i, t)) : std::nullopt;
        if (edge.lag == 0) {
            if (share == 1 || known(frame - 1)) return topology_.value(edge.from, i, t);
            return topology_.value(edge.from, i, window.end);  // the new point has had its newest value all along
        }
        auto const order = std::min<std::int64_t>(edge.predict, frame);
        if (order == 0 || share == 0) return topology_.value(edge.from, i, window.begin);
        for (std::int64_t back = 1; back <= order; ++back)
            if (!known(frame - back)) return std::nullopt;
        return topology_.value(edge.from, i, t);
    }

    void say(sluice::Window const& window, std::string const& what)
    {
        record_.broken.push_back(fmt::format("{}:{} in window {} (iteration {}): {}", self_.name(), self_.rank(),
                                             window.index, window.iteration, what));
    }

    sluice::Participant& self_;
    Topology const& topology_;
    int p_;
    Record& record_;
    double correction_ = 0;
};

}  // namespace

void solve(sluice::Participant& self, Topology const& topology, int p, int member, std::int64_t work, World& world,
           Record& record)
{
    Solver solver(self, topology, p, record);
    bool const grouped = topology.in_group(p);
    if (auto const step = topology.parts[static_cast<std::size_t>(p)].step; step > 0)
        self.propose_window(step == 0.125 ? 0.5 : step);
    std::int64_t marker = 0;
    if (grouped)
        self.keeps([&](sluice::State& state) { state.put_integer("marker", marker); },
                   [&](sluice::State const& state) { marker = state.integer("marker"); });
    solver.tell(0, 0);
    std::int64_t due = 0;
    int iteration = 0;
    for (sluice::Window const& window : self.windows()) {
        auto const say = [&](std::string const& what) {
            record.broken.push_back(fmt::format("{}:{} {} in window {}", self.name(), self.rank(), what, window.index));
        };
        if (window.index != due || window.iteration != iteration) say("skipped or doubled a window");
        if (window.begin != record.times.back()) say("began elsewhere than the last window ended");
        if (marker != window.index && grouped) say("was not restored");
        solver.take(window);
        world.work(member, work);
        marker = window.index + 1;
        solver.tell(window.index + 1, window.end);
        if ((grouped || topology.settles) && !self.accepted(window)) {
            ++iteration;
            continue;
        }
        iteration = 0;
        ++due;
        record.times.push_back(window.end);
        if (p != topology.scene->scene.pace) continue;
        if (topology.adaptive)
            self.next_window(0.25 * (0.4 + 0.6 * std::fmod(0.37 * static_cast<double>(window.index + 1), 1.0)));
        if (window.index == topology.early) self.end_run("enough");
    }
    self.note("done");
}

}  // namespace simulation
