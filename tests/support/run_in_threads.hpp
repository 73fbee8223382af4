#pragma once

#include <atomic>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "coupler/coupler.hpp"
#include "tests/support/scratch.hpp"

//! Runs the participants of a scene in threads of this process, over the loopback transport.
namespace in_threads {

struct Outcome
{
    std::vector<std::string> errors;  //!< per participant; empty: it ended well
};

using Solve = std::function<void(sluice::Participant&)>;

//! `participants`: name and solver, in the scene's order; a participant of several processes stands here once for each,
//! as "water:0", "water:1".
inline Outcome run(std::string const& scene, std::vector<std::pair<std::string, Solve>> const& participants,
                   std::filesystem::path const& directory, std::vector<std::string> const& overrides = {},
                   bool resume = false)
{
    auto const file = directory / "scene.yaml";
    std::ofstream(file) << scene;
    sluice::LoopbackHub hub(static_cast<int>(participants.size()));
    Outcome outcome{std::vector<std::string>(participants.size())};
    std::vector<std::thread> threads;
    for (std::size_t p = 0; p < participants.size(); ++p)
        threads.emplace_back([&, p] {
            try {
                auto const& name = participants[p].first;
                auto const colon = name.find(':');
                sluice::Participant self({.scene = file,
                                          .name = name.substr(0, colon),
                                          .directory = directory / "run",
                                          .overrides = overrides,
                                          .check = false,
                                          .rank = colon == name.npos ? 0 : std::stoi(name.substr(colon + 1)),
                                          .resume = resume,
                                          .transport = hub.connect(static_cast<int>(p))});
                try {
                    participants[p].second(self);
                    self.finish();
                } catch (sluice::Error const& e) {
                    self.fail(e);
                    outcome.errors[p] = e.what();
                }
            } catch (sluice::Error const& e) {
                outcome.errors[p] = e.what();
            }
        });
    for (auto& t : threads) t.join();
    return outcome;
}

}  // namespace in_threads
