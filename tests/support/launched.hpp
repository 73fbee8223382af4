#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "coupler/base/status_page.hpp"
#include "tests/support/run_in_threads.hpp"
#include "tests/support/shell.hpp"

//! Runs of two toys as processes, started by `sluice` or by hand, for tests of the launcher and of faults.
namespace launched {

inline std::string const sluice_command = SLUICE_COMMAND, toy = TOY_COMMAND;

//! Two coupled masses, 1000 windows; `left` and `right` are more keys for their config blocks.
inline std::string scene(std::string const& left = "", std::string const& right = "", std::string const& more = "")
{
    return "sluice: 1\ntime: {end: 1, window: 0.001}\ndata: {place: {columns: {place: {unit: m}}}}\n" + more +
           "participants:\n"
           "  left: {command: " +
           toy + ", config: {mass: 1, wall_spring: 39, middle_spring: 158, place: 1" + left +
           "}}\n"
           "  right: {command: " +
           toy + ", config: {mass: 1, wall_spring: 39, middle_spring: 158, place: 0" + right +
           "}}\ncouplings:\n"
           "  - {from: left, to: right, data: place}\n"
           "  - {from: right, to: left, data: place, lag: 1, predict: linear}\n";
}

//! A scene in a directory of its own, to be run there.
struct Case
{
    explicit Case(std::string const& text) { std::ofstream(file()) << text; }
    std::string file() const { return scratch.path() / "scene.yaml"; }
    std::string out() const { return scratch.path() / "out"; }
    std::filesystem::path log() const { return scratch.path() / "output"; }
    std::vector<std::string> command(std::vector<std::string> const& more = {}) const
    {
        std::vector<std::string> words{sluice_command, "run", file(), "--out", out(), "--no-report", "--quiet"};
        words.insert(words.end(), more.begin(), more.end());
        return words;
    }
    std::vector<std::string> by_hand(std::string const& name) const
    {
        return {toy, file(), "--as", name, "--out", out()};
    }
    shell::Result run(std::vector<std::string> const& more = {}) const { return shell::run(command(more), log()); }
    std::vector<std::string> resuming(std::vector<std::string> const& more = {}) const
    {
        std::vector<std::string> words{sluice_command, "resume", out(), "--no-report", "--quiet"};
        words.insert(words.end(), more.begin(), more.end());
        return words;
    }
    shell::Result resume(std::vector<std::string> const& more = {}) const { return shell::run(resuming(more), log()); }
    //! Waits until a participant computes; its process id.
    int pid_in_window(std::string const& name, std::int64_t window) const
    {
        auto const file = sluice::status_file(out(), name);
        for (int tries = 0; tries < 6000; ++tries) {
            std::error_code none;
            if (std::filesystem::file_size(file, none) == sizeof(sluice::StatusPage)) {
                sluice::MappedStatus const page(file, sluice::MappedStatus::Mode::open);
                if (page->phase == sluice::Phase::running && page->window >= window) return page->pid;
            }
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
        }
        return 0;
    }
    //! Where a mass is in the end [m]; NaN: its process did not get there.
    double final_place(std::string const& name) const
    {
        auto const said = nlohmann::json::parse(shell::slurp(out() + "/.sluice/" + name + ".json"), nullptr, false);
        return said.is_object() ? said.at("facts").value("final place [m]", std::nan("")) : std::nan("");
    }
    //! The windows that have a complete checkpoint.
    std::vector<std::int64_t> checkpoints() const
    {
        std::vector<std::int64_t> windows;
        std::error_code none;
        for (auto const& entry : std::filesystem::directory_iterator(out() + "/checkpoints", none))
            if (std::filesystem::exists(entry.path() / "manifest.json", none))
                windows.push_back(std::stoll(entry.path().filename()));
        std::sort(windows.begin(), windows.end());
        return windows;
    }
    int leftovers() const { return shell::processes_with(out()); }

    in_threads::Scratch scratch;
};

inline bool says(shell::Result const& result, std::string const& text)
{
    bool const found = result.output.find(text) != std::string::npos;
    if (!found) MESSAGE("not in the output: " << result.output);
    return found;
}

inline nlohmann::json summary(Case const& c)
{
    return nlohmann::json::parse(shell::slurp(c.out() + "/summary.json"));
}

}  // namespace launched
