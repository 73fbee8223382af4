#include "tests/bench/runs.hpp"

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace bench {
namespace {

using Clock = std::chrono::steady_clock;
using nlohmann::json;
namespace fs = std::filesystem;

double since_boot(Clock::time_point t)
{
    return std::chrono::duration<double>(t.time_since_epoch()).count();
}

double median(std::vector<double> values)
{
    auto const middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

json row(std::string const& what, std::string const& metric, std::vector<double> const& values, char const* unit,
         std::string const& against, double ratio)
{
    auto const [least, most] = std::minmax_element(values.begin(), values.end());
    return {{"case", what},       {"metric", metric}, {"value", median(values)}, {"unit", unit},
            {"against", against}, {"ratio", ratio},   {"min", *least},           {"max", *most}};
}

//! What distinguishes the runs. Keys of a participant's block, and of an edge, as they stand in the scene.
struct Kind
{
    std::string transport = "auto";
    int windows = 1;
    std::string left = {}, right = {};
    std::string forth = {}, back = ", lag: 1";  //!< left to right, right to left
};

std::string scene_of(Kind const& kind)
{
    std::string const member = "{command: " COUPLING_MEMBER ", config: {";
    return "sluice: 1\ndimension: 3\ntime: {end: " + std::to_string(kind.windows) +
           ", window: 1}\ntransport: " + kind.transport +
           "\ndata: {cloud: {columns: {position: {shape: vector, unit: m}, value: {shape: vector, unit: K}}}}\n"
           "participants:\n  left: " +
           member + kind.left + "}}\n  right: " + member + kind.right +
           "}}\ncouplings:\n"
           "  - {from: left, to: right, data: cloud, sample: hold" +
           kind.forth +
           "}\n"
           "  - {from: right, to: left, data: cloud, sample: hold" +
           kind.back + "}\n";
}

enum class By
{
    hand,
    sluice
};

//! One run in a directory of its own, which is gone with the object.
class Run
{
 public:
    //! Starts it; by hand: right comes `delay` seconds later.
    Run(Kind const& kind, By by, double delay = 0)
    {
        char pattern[] = "/tmp/sluice-bench-XXXXXX";
        if (!::mkdtemp(pattern)) throw std::runtime_error("no directory in /tmp");
        directory_ = pattern;
        std::ofstream(directory_ / "scene.yaml") << scene_of(kind);
        begin_ = Clock::now();
        right_at_ = begin_ + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(delay));
        if (by == By::sluice)
            start({SLUICE_COMMAND, "run", file(), "--out", out(), "--no-report", "--quiet"});
        else {
            start({COUPLING_MEMBER, file(), "--as", "left", "--out", out()});
            right_is_missing_ = true;
        }
        if (delay == 0) start_right();
    }
    Run(Run const&) = delete;
    Run& operator=(Run const&) = delete;
    ~Run()
    {
        std::error_code ignored;
        fs::remove_all(directory_, ignored);
    }

    //! To its end.
    void wait()
    {
        std::this_thread::sleep_until(right_at_);
        start_right();
        for (pid_t const process : processes_) {
            int status = 0;
            ::waitpid(process, &status, 0);
            if (status != 0) throw std::runtime_error("a run ended early");
        }
    }
    double fact(char const* who, char const* name) const { return said(who).at("facts").at(name).get<double>(); }
    double bytes(char const* who) const { return said(who).at("bytes_sent").get<double>(); }
    std::string transport() const { return said("left").at("transport").get<std::string>(); }
    //! s until both were in their first window
    double to_first_window() const
    {
        return std::max(fact("left", "first window [s]"), fact("right", "first window [s]")) - since_boot(begin_);
    }

 private:
    std::string file() const { return directory_ / "scene.yaml"; }
    std::string out() const { return directory_ / "run"; }
    json said(std::string const& who) const { return json::parse(std::ifstream(out() + "/.sluice/" + who + ".json")); }

    void start_right()
    {
        if (std::exchange(right_is_missing_, false)) start({COUPLING_MEMBER, file(), "--as", "right", "--out", out()});
    }
    void start(std::vector<std::string> words)
    {
        std::vector<char*> argv;
        for (auto& word : words) argv.push_back(word.data());
        argv.push_back(nullptr);
        pid_t process = -1;
        if (::posix_spawn(&process, argv[0], nullptr, nullptr, argv.data(), environ) != 0)
            throw std::runtime_error(words[0] + " cannot be started");
        processes_.push_back(process);
    }

    fs::path directory_;
    Clock::time_point begin_, right_at_;
    bool right_is_missing_ = false;
    std::vector<pid_t> processes_;
};

}  // namespace

json start_up(RunEffort const& effort)
{
    constexpr double goal = 40;  // ms
    auto results = json::array();
    std::vector<double> hand, sluice;
    for (int n = 0; n < effort.starts; ++n)
        for (auto const& [by, times] : {std::pair{By::hand, &hand}, std::pair{By::sluice, &sluice}}) {
            Run run(Kind{}, by);
            run.wait();
            times->push_back(1e3 * run.to_first_window());
        }
    auto const metric = "two processes to their first window";
    results.push_back(row("start by hand", metric, hand, "ms", "40 ms", median(hand) / goal));
    results.push_back(row("start by sluice run", metric, sluice, "ms", "40 ms", median(sluice) / goal));
    return results;
}

//! All at once, since they sleep. What counts is what the process took in all, less what it takes with nothing to wait
//! for.
json waiting(RunEffort const& effort)
{
    constexpr double allowed = 0.5;  // s of CPU a minute
    struct Case
    {
        char const* name;
        char const* kind;  //!< of transport, as the participants say
        std::string transport;
        By by;
    };
    Case const cases[] = {{"wait, shm", "shm", "auto", By::hand},
                          {"wait, zmq ipc", "zmq", "zmq", By::hand},
                          {"wait, mpi", "mpi", "mpi", By::sluice}};
    auto const rest = "rest: " + std::to_string(effort.wait), late = "late: " + std::to_string(effort.wait);
    struct Runs
    {
        std::unique_ptr<Run> none, computing, absent;
    };
    std::vector<Runs> all;
    for (auto const& c : cases) {
        bool const by_hand = c.by == By::hand;  // mpirun starts all of them at once
        auto const make = [&](std::string const& right, double delay = 0) {
            return std::make_unique<Run>(
                Kind{.transport = c.transport, .right = right, .forth = ", lag: 1", .back = ""}, c.by, delay);
        };
        all.push_back({make(""), make(rest), by_hand ? make("", effort.wait) : make(late)});
    }
    auto results = json::array();
    for (std::size_t i = 0; i < std::size(cases); ++i) {
        all[i].none->wait();
        if (all[i].none->transport() != cases[i].kind)
            throw std::runtime_error("not over " + std::string(cases[i].kind));
        double const bare = all[i].none->fact("left", "cpu [s]");
        for (auto const& [run, metric] :
             {std::pair{all[i].computing.get(), "for a peer that computes, CPU a minute"},
              std::pair{all[i].absent.get(), "for a peer that is not there, CPU a minute"}}) {
            run->wait();
            double const a_minute = std::max(0.0, run->fact("left", "cpu [s]") - bare) / effort.wait * 60;
            results.push_back(row(cases[i].name, metric, {a_minute}, "s", "0.5 s", a_minute / allowed));
        }
    }
    return results;
}

//! In the course of a run: the first frame is always whole.
json bytes_sent()
{
    constexpr int points = 10'000, start = 10, windows = 50;
    auto const measure = [&](std::string const& more, std::string const& edge) {
        auto const in_all = [&](int count) {
            Run run({.windows = count, .left = "points: " + std::to_string(points) + more, .forth = edge}, By::hand);
            run.wait();
            return run.bytes("left");
        };
        return (in_all(start + windows) - in_all(start)) / windows;
    };
    double const all = measure("", "");
    auto results = json::array();
    auto const add = [&](char const* name, double bytes) {
        results.push_back(row(std::string("sent, ") + name, "bytes a window, 10000 points", {bytes}, "B",
                              "all columns of all points", bytes / all));
    };
    add("all columns of all points", all);
    add("positions unchanged", measure(", moving: false", ""));
    add("nothing changed", measure(", moving: false, changing: false", ""));
    add("region with a tenth of the points",
        measure("", ", region: {min: [-1, -1, -1], max: [" + std::to_string(points / 10 - 0.25) + ", 1, 1]}"));
    return results;
}

//! The exchange of the serial scheme, in which each waits for the other, is what there is to hide.
json overlap(RunEffort const& effort)
{
    auto results = json::array();
    for (std::string const transport : {"auto", "zmq"}) {
        auto const beside_computing = [&](double compute, std::string const& forth) {  // s a window
            auto const both = "points: " + std::to_string(effort.points) + ", compute: " + std::to_string(compute);
            Run run({.transport = transport, .windows = effort.windows, .left = both, .right = both, .forth = forth},
                    By::hand);
            run.wait();
            return std::max(run.fact("left", "beside computing [s]"), run.fact("right", "beside computing [s]"));
        };
        std::vector<double> serial, parallel, hidden;
        for (int n = 0; n < effort.repetitions; ++n) {
            serial.push_back(1e3 * beside_computing(0, ""));
            parallel.push_back(1e3 * beside_computing(effort.compute, ", lag: 1"));
            hidden.push_back(100 * (1 - parallel.back() / serial.back()));
        }
        auto const name = "overlap, " + (transport == "auto" ? std::string("shm") : "zmq ipc") + ", " +
                          std::to_string(effort.points) + " points";
        auto const against = "serial, without computing";
        results.push_back(row(name, "serial: a window without computing", serial, "ms", against, 1));
        results.push_back(row(name, "parallel: a window beside its computing", parallel, "ms", against,
                              median(parallel) / median(serial)));
        results.push_back(row(name, "exchange that is hidden", hidden, "%", "100 %", median(hidden) / 100));
    }
    return results;
}

}  // namespace bench
