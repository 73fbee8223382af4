#pragma once

#include <algorithm>
#include <random>
#include <sstream>

#include "tests/support/fault_row.hpp"
#include "tests/support/launched.hpp"

//! What every row of the fault matrix with processes asks for.
namespace matrix {

using namespace launched;
using sluice::test::Row;
using std::chrono::milliseconds;

inline std::mt19937& random_numbers()
{
    static std::mt19937 numbers(20240711);
    return numbers;
}

inline milliseconds random_time(int longest_ms)
{
    return milliseconds(std::uniform_int_distribution<int>(0, longest_ms)(random_numbers()));
}

//! The test settings of the matrix: silence 2 s.
inline std::string const silence = "timeouts: {silence: 2}\n";

inline std::string first_line(shell::Result const& result)
{
    return result.output.substr(0, result.output.find('\n'));
}

inline bool has(std::string const& text, std::string const& part)
{
    bool const found = text.find(part) != std::string::npos;
    if (!found) MESSAGE("\"" << part << "\" is not in: " << text);
    return found;
}

//! One line names participant, process, cause, window and simulated time; nobody is left.
inline void check_fatal(Case const& c, shell::Result const& result, int exit, std::string const& participant,
                        std::string const& cause)
{
    CHECK(result.exit == exit);
    auto const line = first_line(result);
    CHECK(has(line, "participant \"" + participant + "\""));
    CHECK(has(line, cause));
    CHECK(has(line, "process "));
    if (line.find("before its first window") == line.npos) {
        CHECK(has(line, "in window "));
        CHECK(has(line, " (t = "));
    }
    CHECK(c.leftovers() == 0);
}

//! Nothing is in the way of a run in the same directory.
inline void check_starts_again(Case const& c)
{
    auto const again = shell::run(c.command({"--set", "time.end=0.01"}), c.log());
    CHECK_MESSAGE(again.exit == 0, again.output);
}

//! The newest complete checkpoint can be gone on from.
inline void check_resumes(Case const& c)
{
    auto const resumed = c.resume();
    CHECK_MESSAGE(resumed.exit == 0, resumed.output);
}

//! The same for two that were started by hand; `first` and `second` are their command lines.
inline void check_resume_by_hand(Case const& c, std::vector<std::string> first, std::vector<std::string> second)
{
    for (auto* words : {&first, &second}) words->push_back("--resume");
    shell::Background other(first, c.scratch.path() / "resumed");
    auto const one = shell::run(second, c.log()), two = other.wait(60);
    CHECK_MESSAGE(one.exit == 0, one.output);
    CHECK_MESSAGE(two.exit == 0, two.output);
}

//! The process of a participant that a launcher has started (its --check aside), 0: none.
inline int child_of(int launcher, std::string const& participant)
{
    std::istringstream children(
        shell::slurp("/proc/" + std::to_string(launcher) + "/task/" + std::to_string(launcher) + "/children"));
    for (int child; children >> child;) {
        auto words = shell::slurp("/proc/" + std::to_string(child) + "/cmdline");
        std::replace(words.begin(), words.end(), '\0', ' ');
        if (words.find("--as " + participant + " ") != words.npos && words.find("--check") == words.npos) return child;
    }
    return 0;
}

//! The same run, undisturbed, and where its masses end.
inline std::pair<double, double> undisturbed(std::string const& end)
{
    Case c(scene());
    auto const result = c.run({"--set", "time.end=" + end});
    REQUIRE_MESSAGE(result.exit == 0, result.output);
    return {c.final_place("left"), c.final_place("right")};
}

inline std::pair<double, double> end_of(Case const& c)
{
    return {c.final_place("left"), c.final_place("right")};
}

//! toy_stream: `from` sends to `to`; keys for both.
inline std::string stream_scene(std::string const& from, std::string const& to, std::string const& more = "",
                                std::string const& end = "1")
{
    return "sluice: 1\ntime: {end: " + end + ", window: 0.001}\ndata: {place: {columns: {place: {unit: m}}}}\n" + more +
           "participants:\n  from: {command: " STREAM_COMMAND ", config: {" + from +
           "}}\n  to: {command: " STREAM_COMMAND ", config: {" + to +
           "}}\ncouplings: [{from: from, to: to, data: place}]\n";
}

//! Seconds since a file was last written to.
inline double age_of(std::string const& file)
{
    auto const written = std::filesystem::last_write_time(file);
    return std::chrono::duration<double>(std::filesystem::file_time_type::clock::now() - written).count();
}

inline std::string joined(std::vector<std::string> const& words)
{
    std::string text;
    for (auto const& word : words) text += "'" + word + "' ";
    return text;
}

inline shell::Result bash(Case const& c, std::string const& script)
{
    return shell::run({"/bin/bash", "-c", script}, c.log());
}

}  // namespace matrix
