// Rows F1 to F6 of the fault matrix: participants that die, hang, never come.

#include "tests/faults/matrix.hpp"

using namespace matrix;

namespace {

enum class Moment
{
    any,       //!< of the whole run
    init,      //!< before the first window, or in the first ones
    transfer,  //!< while 1.6 MB a window are under way
    finalize   //!< in the last windows, or at the goodbye
};

//! Waits for the moment; the process of `victim` then, 0: it is gone.
int wait_for(Moment moment, Case const& c, int launcher, std::string const& victim)
{
    int pid = 0;
    for (int tries = 0; tries < 4000 && pid == 0; ++tries) {
        pid = child_of(launcher, victim);
        if (pid == 0) std::this_thread::sleep_for(milliseconds(1));
    }
    switch (moment) {
        case Moment::any:
            std::this_thread::sleep_for(random_time(1400));
            break;
        case Moment::init:
            std::this_thread::sleep_for(random_time(60));
            break;
        case Moment::transfer:
            c.pid_in_window(victim, 1);
            std::this_thread::sleep_for(random_time(200));
            break;
        case Moment::finalize:
            c.pid_in_window(victim, 970);
            std::this_thread::sleep_for(random_time(45));
    }
    return child_of(launcher, victim) == pid ? pid : 0;
}

}  // namespace

TEST_CASE("F1: kill -9 of a participant at a random moment")
{
    int died = 0, in_moment[4] = {};
    {
        Row row("F1", "kill -9 at init, work, transfer and end", {.brief = 8, .stated = 200});
        while (row.next()) {
            auto const moment = static_cast<Moment>(row.round() % 4);
            bool const stream = moment == Moment::transfer, first = row.round() / 4 % 2 == 0;
            std::string const victim = stream ? (first ? "from" : "to") : (first ? "left" : "right");
            Case c(stream ? stream_scene("points: 200000", "nap: 0.001")
                          : scene(", nap: 0.001", "", "checkpoint: {windows: 100}\n"));
            shell::Background run(c.command(), c.log());
            int const pid = wait_for(moment, c, run.pid(), victim);
            if (pid > 0) ::kill(pid, SIGKILL);
            auto const result = run.wait(60);
            if (result.exit == 0) continue;  // it was done before
            ++died;
            ++in_moment[row.round() % 4];
            row.took(result.seconds, 1.0);
            check_fatal(c, result, 3, victim, "was ended by signal 9");
            CHECK(has(first_line(result), "process " + std::to_string(pid)));
            CHECK(result.output.find("participant \"" + victim + "\"") == 0);  // the first line is the root cause
            if (!stream && !c.checkpoints().empty() && row.round() % 3 == 0)
                check_resumes(c);
            else if (row.round() % 3 == 0)
                check_starts_again(c);
        }
        CHECK(died > row.repeats() / 2);  // else this tries little
    }
    MESSAGE("F1: " << died << " were killed at work: any moment " << in_moment[0] << ", init " << in_moment[1]
                   << ", transfer " << in_moment[2] << ", end " << in_moment[3]);
}

TEST_CASE("F2: a participant that aborts, exits, throws: the end of its log is shown")
{
    Row row("F2", "abort(), exit(9), throw", {.brief = 3, .stated = 100});
    while (row.next()) {
        std::string const faults[] = {"crash", "exit", "throw"},
                          causes[] = {"was ended by signal 6", "ended with exit code 9", "toy: thrown"};
        auto const kind = static_cast<std::size_t>(row.round() % 3);
        Case c(stream_scene("says: 1, nap: 0.001, fault: " + faults[kind] + ", fault_window: 200", "",
                            "checkpoint: {windows: 60}\n", "0.3"));
        auto const result = c.run();
        row.took(age_of(c.out() + "/from.log"), 1.0);  // since its last words
        check_fatal(c, result, kind == 2 ? 6 : 3, "from", causes[kind]);
        CHECK(has(result.output, "from.log, ends with:"));
        int const shown = kind == 2 ? 19 : 20;  // what it threw is the twentieth
        CHECK(has(result.output, "window " + std::to_string(201 - shown) + ", line 0"));
        CHECK(has(result.output, "window 200, line 0"));
        CHECK(result.output.find("window " + std::to_string(200 - shown) + ", line 0") == std::string::npos);
        CHECK(c.checkpoints() == std::vector<std::int64_t>{120, 180});
        check_resumes(c);  // the fault does not come again
    }
}

TEST_CASE("F3: a participant that is stopped (SIGSTOP): found by its silence, by the launcher and by a peer alone")
{
    Row row("F3", "SIGSTOP, launched and by hand", {.brief = 2, .stated = 50});
    while (row.next()) {
        bool const launched = row.round() % 2 == 0, first = row.round() / 2 % 2 == 0;
        std::string const victim = first ? "left" : "right", survivor = first ? "right" : "left";
        auto const transport = row.round() / 4 % 2 == 0 ? "auto" : "zmq";
        auto text = scene(", nap: 0.01", "", silence + "checkpoint: {windows: 10}\ntransport: " + transport + "\n");
        Case c(text.replace(text.find("end: 1,"), 7, "end: 0.2,"));
        std::unique_ptr<shell::Background> run, other;
        if (launched)
            run = std::make_unique<shell::Background>(c.command(), c.log());
        else {
            run = std::make_unique<shell::Background>(c.by_hand(survivor), c.log());
            other = std::make_unique<shell::Background>(c.by_hand(victim), c.scratch.path() / "victim");
        }
        int const pid = c.pid_in_window(victim, 15);
        REQUIRE(pid > 0);
        std::this_thread::sleep_for(random_time(30));
        ::kill(pid, SIGSTOP);
        auto const result = run->wait(30);
        auto const log = launched ? c.out() + "/" + survivor + ".log" : c.log().string();
        row.took(result.seconds - age_of(log), 2.0 + 1.0);  // until the survivor says so
        if (other) {
            ::kill(pid, SIGCONT);
            CHECK(other->wait(30).exit == 3);  // it finds the survivor gone
        }
        check_fatal(c, result, 3, victim, "no heartbeat for 2 s");
        CHECK(has(first_line(result), "process " + std::to_string(pid)));
        if (launched)
            check_resumes(c);
        else
            check_resume_by_hand(c, c.by_hand("left"), c.by_hand("right"));
    }
}

TEST_CASE("F4: a solver that never ends its window: first a warning, then the end, both with who waits for whom")
{
    struct Hanging
    {
        Case c{scene(", nap: 0.01", ", fault: hang, fault_window: 50", silence + "checkpoint: {windows: 20}\n")};
        std::unique_ptr<shell::Background> run;
    };
    Row row("F4", "endless loop in window 50", {.brief = 1, .stated = 20});
    std::vector<std::unique_ptr<Hanging>> all;  // at the same time: they only wait
    auto const hanging_for = [](Case const& c) { return c.pid_in_window("right", 50) > 0; };
    for (int n = 0; n < row.repeats(); ++n) {
        all.push_back(std::make_unique<Hanging>());
        auto words = all.back()->c.command({"--set", "timeouts.window=33"});
        all.back()->run = std::make_unique<shell::Background>(words, all.back()->c.log());
        if (n % 4 == 3) CHECK(hanging_for(all.back()->c));
    }
    while (row.next()) {
        auto& [c, run] = *all[static_cast<std::size_t>(row.round())];
        REQUIRE(hanging_for(c));
        auto const result = run->wait(120);
        CHECK(result.exit == 4);
        std::string const graph = "computing: \"right\" in window 50 of 1000 (t = 0.05 s) since ",
                          waits = "waiting for that: \"left\"";
        auto const warning = result.output.find("\"right\" takes more than 10 times as long as for its other windows");
        auto const end = result.output.find("a window takes longer than timeouts.window = 33 s: " + graph);
        REQUIRE(warning != std::string::npos);
        REQUIRE(end != std::string::npos);
        CHECK(warning < end);
        CHECK(result.output.find(graph, warning) < end);
        CHECK(result.output.find(waits, warning) < end);
        CHECK(result.output.find(waits, end) != std::string::npos);
        auto const since = [&](std::size_t from) {
            return std::stod(result.output.substr(result.output.find(graph, from) + graph.size()));
        };
        row.took(since(warning), 30.0 + 1.0);
        CHECK(since(end) <= 33.0 + 1.0 + (std::getenv("SLUICE_VERIFY_JSONL") ? 0 : Row::hang));
        CHECK(c.leftovers() == 0);
        check_resumes(c);
    }
}

TEST_CASE("F5: wired so that each waits for the other: refused before anything starts")
{
    Row row("F5", "two lag-0 edges in a circle", {.brief = 1, .stated = 10});
    while (row.next()) {
        auto text = scene();
        text.replace(text.find(", lag: 1, predict: linear"), 25, "");
        Case c(text);
        auto const result = row.round() % 2 == 0 ? c.run() : shell::run({sluice_command, "check", c.file()}, c.log());
        row.took(result.seconds, 1.0);
        CHECK(result.exit == 2);
        CHECK(says(result, "left -> right -> left"));
        CHECK(says(result, "scene.yaml:"));
        CHECK(c.leftovers() == 0);
        CHECK(!std::filesystem::exists(c.out() + "/left.log"));
    }
}

namespace {

//! Seconds that a process' threads have computed: to the nanosecond, where /proc/PID/stat counts hundredths.
double work_of(int pid)
{
    double nanoseconds = 0;
    std::error_code gone;
    for (auto const& thread : std::filesystem::directory_iterator("/proc/" + std::to_string(pid) + "/task", gone)) {
        double own = 0;
        std::istringstream(shell::slurp(thread.path() / "schedstat")) >> own;
        nanoseconds += own;
    }
    return 1e-9 * nanoseconds;
}

}  // namespace

TEST_CASE("F6: a partner never comes: named within timeouts.connect, with progress lines and next to no work")
{
    Row row("F6", "a partner never comes", {.brief = 1, .stated = 20});
    int const limit = row.repeats() >= 20 ? 30 : 12;  // s
    struct Waiting
    {
        explicit Waiting(std::string const& text) : c(text), run(c.by_hand("left"), c.log()) {}
        Case c;
        shell::Background run;
        double work = 0;
    };
    std::vector<std::unique_ptr<Waiting>> all;  // at the same time: they only wait
    auto const text = scene("", "", "timeouts: {connect: " + std::to_string(limit) + "}\n");
    for (int n = 0; n < row.repeats(); ++n) all.push_back(std::make_unique<Waiting>(text));
    std::this_thread::sleep_for(std::chrono::seconds(3));
    std::vector<double> before;
    for (auto const& one : all) before.push_back(work_of(one->run.pid()));
    auto const begin = std::chrono::steady_clock::now();
    std::this_thread::sleep_for(std::chrono::seconds(limit - 5));
    double const minutes = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count() / 60;
    for (std::size_t n = 0; n < all.size(); ++n) all[n]->work = (work_of(all[n]->run.pid()) - before[n]) / minutes;
    double most = 0;
    while (row.next()) {
        auto& [c, run, work] = *all[static_cast<std::size_t>(row.round())];
        auto const result = run.wait(60);
        most = std::max(most, work);
        CHECK(work < 0.5);  // s a minute
        CHECK(work >= 0);
        CHECK(result.exit == 4);
        CHECK(says(result, "\"right\" did not come within " + std::to_string(limit) + " s. Start with:"));
        int lines = 0;
        for (std::size_t at = 0; (at = result.output.find("left: waiting for \"right\"", at)) != std::string::npos;
             ++at)
            ++lines;
        CHECK(lines >= limit / 5 - 1);
        CHECK(c.leftovers() == 0);
        if (row.round() % 5 == 0) check_starts_again(c);
    }
    MESSAGE("F6: at most " << most << " s of work a minute");
}
