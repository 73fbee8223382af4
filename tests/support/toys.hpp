#pragma once

#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <memory>
#include <new>
#include <string>
#include <thread>
#include <vector>

#include "coupler/coupler.hpp"

//! Solvers of a few lines, for tests of the coupling: each speaks to its partners about one number.
namespace toys {

inline constexpr std::int64_t one_point[] = {1};

//! Keys that make a toy misbehave in a given window, for tests of what then happens.
struct Fault
{
    std::int64_t window = -1;
    std::size_t kind = 0;  //!< index into `kinds`
    double nap = 0;        //!< s slept in every window
    bool again = false;    //!< also in a process that goes on from a checkpoint
    static constexpr const char* kinds[] = {"none",  "crash",  "exit", "throw", "nan",
                                            "leave", "vanish", "hang", "memory", "linger"};

    static Fault read(sluice::Reader& r)
    {
        Fault f;
        f.kind = r.choice_or("fault", 0, {std::begin(kinds), std::end(kinds)});
        f.window = r.integer_or("fault_window", -1);
        f.nap = r.number_or("nap", 0.0, {.min = 0.0, .unit = "s"});
        f.again = r.flag_or("fault_again", false);
        return f;
    }

    void spare(bool resumed) { window = resumed && !again ? -1 : window; }
    bool leaves(std::int64_t now) const { return kind == 5 && now == window; }
    //! Called in each window; may not return. Returns what is added to the value that is sent.
    double strike(std::int64_t now) const
    {
        if (nap > 0) std::this_thread::sleep_for(std::chrono::duration<double>(nap));
        if (now != window) return 0.0;
        if (kind == 1) std::abort();
        if (kind == 2) std::exit(9);
        if (kind == 3) throw sluice::Error("toy: thrown on purpose.", sluice::Exit::numerical);
        if (kind == 4) return std::nan("");
        if (kind == 6) std::_Exit(0);
        if (kind == 7)
            for (;;) std::this_thread::sleep_for(std::chrono::seconds(1));  // alive, and never done
        if (kind == 8) throw std::bad_alloc();
        if (kind == 9) std::atexit([] { std::this_thread::sleep_for(std::chrono::seconds(1)); });  // a process slow to end
        return 0.0;
    }
};

//! Told the state at the start and at the end of every window: time [s] and the toy's own value.
using Watcher = std::function<void(double time, double value)>;

//! One mass of the two-mass oscillator (C09b), or of more, sub-cycled with velocity Verlet; tells its partners its
//! place [m].  m x'' = -wall_spring x - sum over partners of middle_spring (x - x_partner)
inline void oscillator(sluice::Participant& self, Watcher const& watch = {})
{
    auto r = self.config();
    double const mass = r.number("mass", {.above = 0.0, .unit = "kg"});
    double const wall = r.number("wall_spring", {.min = 0.0, .unit = "N/m"});
    double const middle = r.number("middle_spring", {.min = 0.0, .unit = "N/m"});
    double x = r.number("place", {.unit = "m"}), v = 0;
    auto const steps = r.integer_or("steps", 1, {.min = 1});
    Fault fault = Fault::read(r);
    fault.spare(self.resumes());
    bool const keep = r.flag_or("keep", true);
    self.sends({"place"});
    self.takes({"place"});
    r.finish();
    if (self.checking()) return;
    if (keep)
        self.keeps(
            [&](sluice::State& state) {
                state.put_number("place", x);
                state.put_number("velocity", v);
            },
            [&](sluice::State const& state) {
                x = state.number("place");
                v = state.number("velocity");
            });
    auto const partners = self.senders("place");
    auto tell = [&](double extra) {
        double const value = x + extra;
        for (auto const& receiver : self.receivers("place"))
            self.write(receiver, "place", one_point, {std::span(&value, 1)});
    };
    tell(0.0);
    if (watch) watch(0.0, x);
    for (sluice::Window const& window : self.windows()) {
        if (fault.leaves(window.index)) break;
        std::vector<sluice::Samples> others;
        for (auto const& partner : partners) others.push_back(self.read(partner, "place", window));
        double const h = window.length / static_cast<double>(steps);
        auto force = [&](double t) {
            double sum = -wall * x;
            for (auto& other : others) sum -= middle * (x - other.columns(t)[0][0]);
            return sum;
        };
        for (std::int64_t k = 0; k < steps; ++k) {
            double const t = window.begin + h * static_cast<double>(k);
            v += h / 2 * force(t) / mass;
            x += h * v;
            v += h / 2 * force(t + h) / mass;
        }
        tell(fault.strike(window.index));
        if (watch) watch(window.end, x);
    }
    self.fact("final place [m]", x);
}

//! Two oscillators, "left" and "right", five windows; `timeouts` as in a scene. For participants in one process: each
//! needs its own, since what is asked of a configuration is noted down in it.
inline std::shared_ptr<sluice::LoadedScene> two_masses(std::string const& timeouts)
{
    auto const text = "sluice: 1\ntime: {end: 0.5, window: 0.1}\ntimeouts: " + timeouts + R"(
data: {place: {columns: {place: {unit: m}}}}
participants:
  left: {command: none, config: {mass: 1, wall_spring: 1, middle_spring: 1, place: 1}}
  right: {command: none, config: {mass: 1, wall_spring: 1, middle_spring: 1, place: 0}}
couplings: [{from: left, to: right, data: place}, {from: right, to: left, data: place, lag: 1}]
)";
    return std::make_shared<sluice::LoadedScene>(sluice::load_scene_text(text, "two.yaml"));
}

}  // namespace toys
