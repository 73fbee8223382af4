// Participants of several processes: frames go from process to process, by the boxes that the receivers cover.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <cmath>
#include <map>
#include <mutex>

#include "tests/support/run_in_threads.hpp"

namespace {

constexpr int grains = 40;

//! Grain i of 40 on a line that moves to the right; its place and velocity.
double place(int i, double t)
{
    return 0.5 + i + 0.3 * t;
}

struct Sums
{
    std::mutex mutex;
    std::map<std::pair<std::int64_t, std::int64_t>, double> force;  //!< window, id: what the grain's owner got
    std::map<std::pair<std::int64_t, std::int64_t>, int> given;     //!< window, id: how many water processes saw it
};

//! One of `of` processes that own the grains by place: those that left go to the next one.
in_threads::Solve owner(int rank, int of, Sums& sums)
{
    return [=, &sums](sluice::Participant& self) {
        self.config().finish();
        CHECK(self.rank() == rank);
        CHECK(self.ranks() == of);
        auto tell = [&](double t) {
            std::vector<std::int64_t> ids;
            std::vector<double> position, velocity, spin, radius;
            for (int i = grains - 1; i >= 0; --i) {
                if (static_cast<int>(place(i, t) * of / (grains + 4)) != rank) continue;
                ids.push_back(i);
                position.insert(position.end(), {place(i, t), 0.5});
                velocity.insert(velocity.end(), {0.3, 0.0});
                spin.push_back(0);
                radius.push_back(0.4);
            }
            self.write("water", sluice::Kinematics{ids, position, velocity, spin, radius});
        };
        tell(0);
        for (sluice::Window const& window : self.windows()) {
            auto const load = self.read<sluice::Load>("water", window).at(window.begin);
            std::lock_guard const lock(sums.mutex);
            for (std::size_t k = 0; k < load.id.size(); ++k)
                sums.force[{window.index, load.id[k]}] += load.force[2 * k];
            tell(window.end);
        }
    };
}

//! One of `of` processes that cover a part of the line: gives each grain it sees a force of 1 / (how many see it).
in_threads::Solve water(int rank, int of, Sums& sums)
{
    return [=, &sums](sluice::Participant& self) {
        self.config().finish();
        double const width = static_cast<double>(grains + 4) / of;
        sluice::Box const box{{rank * width, 0, 0}, {(rank + 1) * width, 1, 0}};
        self.covers(box);
        self.write("grains", sluice::Load{});
        for (sluice::Window const& window : self.windows()) {
            auto const k = self.read<sluice::Kinematics>("grains", window).at(window.end);
            std::vector<double> force(2 * k.id.size()), torque(k.id.size());
            for (std::size_t i = 0; i < k.id.size(); ++i) {
                double const x = k.position[2 * i], left = std::max(x - 0.4, box.min[0]),
                             right = std::min(x + 0.4, box.max[0]);
                force[2 * i] = (right - left) / 0.8;  // the part of the grain that is in the box
                std::lock_guard const lock(sums.mutex);
                CHECK(right >= left);  // others are not sent
                ++sums.given[{window.index, k.id[i]}];
            }
            self.write("grains", sluice::Load{k.id, force, torque});
        }
    };
}

}  // namespace

TEST_CASE("ranks: M processes of one and N of another, by the overlap of their boxes, nothing lost or doubled")
{
    for (int m : {1, 2, 3})
        for (int n : {1, 2, 3}) {
            CAPTURE(m);
            CAPTURE(n);
            std::string const scene = fmt::format(R"(sluice: 1
time: {{end: 10, window: 1}}
participants: {{grains: {{command: none, ranks: {}}}, water: {{command: none, ranks: {}}}}}
couplings: [{{from: grains, to: water, data: kinematics}}, {{from: water, to: grains, data: load, lag: 1}}]
)",
                                                  m, n);
            Sums sums;
            std::vector<std::pair<std::string, in_threads::Solve>> all;
            for (int r = 0; r < m; ++r) all.emplace_back("grains:" + std::to_string(r), owner(r, m, sums));
            for (int r = 0; r < n; ++r) all.emplace_back("water:" + std::to_string(r), water(r, n, sums));
            in_threads::Scratch scratch;
            auto const outcome = in_threads::run(scene, all, scratch.path());
            for (auto const& error : outcome.errors) CHECK(error == "");
            int shared = 0;
            for (std::int64_t window = 1; window < 10; ++window)
                for (int i = 0; i < grains; ++i) {
                    CHECK(std::abs(sums.force[{window, i}] - 1) < 1e-14);
                    shared += sums.given[{window, i}] > 1;
                }
            CHECK((shared > 0) == (n > 1));
        }
}

namespace {

//! A process of a participant whose first one has all points; the others must get none.
in_threads::Solve spokesman(int rank, bool tells, std::string const& takes, std::vector<std::size_t>& points)
{
    return [=, &points](sluice::Participant& self) {
        self.config().finish();
        if (rank > 0) self.covers({{1, 1, 1}, {-1, -1, -1}});
        std::vector<std::int64_t> ids;
        for (int i = 0; i < grains && rank == 0; ++i) ids.push_back(i);
        std::vector<double> const two(2 * ids.size(), 1.0), one(ids.size(), 1.0);
        auto const tell = [&] {
            if (tells) self.write("water", sluice::Kinematics{ids, two, two, one, one});
        };
        tell();
        for (sluice::Window const& window : self.windows()) {
            auto samples = self.read("water", takes, window);
            points[static_cast<std::size_t>(rank)] += samples.ids().size();
            samples.columns(window.end);
            tell();
        }
    };
}

//! One process that sends a point for each grain, from the initial state on.
in_threads::Solve source(std::string const& data)
{
    return [=](sluice::Participant& self) {
        self.config().finish();
        std::vector<std::int64_t> ids;
        for (int i = 0; i < grains; ++i) ids.push_back(i);
        std::vector<double> const two(2 * ids.size(), 0.5), one(ids.size(), 2.0);
        auto const tell = [&] {
            if (data == "load")
                self.write("grains", sluice::Load{ids, two, one});
            else
                self.write("grains", sluice::Kinematics{ids, two, two, one, one});
        };
        tell();
        for ([[maybe_unused]] sluice::Window const& window : self.windows()) tell();
    };
}

}  // namespace

TEST_CASE("ranks: who covers nothing gets no points, with places or without, whether something goes back or not")
{
    for (std::string const data : {"load", "kinematics"})
        for (bool const tells : {false, true}) {
            CAPTURE(data);
            CAPTURE(tells);
            std::string const scene = fmt::format(R"(sluice: 1
time: {{end: 10, window: 1}}
ledger: {{on-violation: stop, tolerance: 1e-13}}
participants: {{grains: {{command: none, ranks: 3}}, water: {{command: none}}}}
couplings: [{}{{from: water, to: grains, data: {}, lag: 1}}]
)",
                                                  tells ? "{from: grains, to: water, data: kinematics}, " : "", data);
            std::vector<std::size_t> points(3);
            std::vector<std::pair<std::string, in_threads::Solve>> all;
            for (int r = 0; r < 3; ++r)
                all.emplace_back("grains:" + std::to_string(r), spokesman(r, tells, data, points));
            all.emplace_back("water", source(data));
            in_threads::Scratch scratch;
            auto const outcome = in_threads::run(scene, all, scratch.path());
            for (auto const& error : outcome.errors) CHECK(error == "");
            CHECK(points == std::vector<std::size_t>{10 * grains, 0, 0});
        }
}
