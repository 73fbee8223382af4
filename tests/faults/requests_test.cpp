// Rows F13, F14, F17 to F20 of the fault matrix: what users ask for or get wrong, numbers, memory.

#include <sys/stat.h>

#include "tests/faults/matrix.hpp"

using namespace matrix;

TEST_CASE("F13: a second participant of a name, a second run: refused with the owner's process, the first unharmed")
{
    auto const whole = undisturbed("0.6");
    Row row("F13", "a second participant, a second run", {.brief = 2, .stated = 20});
    while (row.next()) {
        Case c(scene(", nap: 0.002", ""));
        shell::Background first(c.command({"--set", "time.end=0.6"}), c.log());
        int const pid = c.pid_in_window("left", 5);
        REQUIRE(pid > 0);
        auto const twin = shell::run(c.by_hand("left"), c.scratch.path() / "twin");
        row.took(twin.seconds, 2.0);
        CHECK(twin.exit == 5);
        CHECK(says(twin, "(process " + std::to_string(pid) + ")"));
        auto const second = shell::run(c.command(), c.scratch.path() / "second");
        row.took(second.seconds, 2.0);
        CHECK(second.exit == 5);
        CHECK(says(second, "(process " + std::to_string(first.pid()) + ")"));
        CHECK(first.wait(60).exit == 0);
        CHECK(end_of(c) == whole);
        CHECK(c.leftovers() == 0);
    }
}

TEST_CASE("F14: partners with different scenes: both print the key that differs, and both values")
{
    struct Difference
    {
        std::string set, here, there;
    };
    Difference const differences[] = {
        {"time.end=0.5", "time.end = 1", "time.end = 0.5"},
        {"couplings.1.predict=none", "couplings[1].predict = linear", "couplings[1].predict = none"},
        {"time.window=0.002", "time.window = 0.001", "time.window = 0.002"}};
    Row row("F14", "another --set on one side", {.brief = 3, .stated = 20});
    while (row.next()) {
        auto const& [set, here, there] = differences[row.round() % 3];
        bool const first = row.round() / 3 % 2 == 0;
        Case c(scene());
        auto other = c.by_hand(first ? "right" : "left");
        other.insert(other.end(), {"--set", set});
        shell::Background plain(c.by_hand(first ? "left" : "right"), c.scratch.path() / "plain");
        auto const changed = shell::run(other, c.log());
        auto const side = plain.wait(20);
        row.took(std::max(changed.seconds, side.seconds), 2.0);
        for (auto const& one : {changed, side}) {
            CHECK((one.exit == 5 || one.exit == 3));  // who sees it first says so, and tells the other
            CHECK(has(one.output, here));
            CHECK(has(one.output, there));
        }
        CHECK((changed.exit == 5 || side.exit == 5));
        CHECK(c.leftovers() == 0);
        if (row.round() % 4 == 0) check_starts_again(c);
    }
}

TEST_CASE("F17: SIGTERM or SIGINT to the launcher or a participant at a random moment")
{
    auto const whole = undisturbed("1");
    int stopped = 0;
    Row row("F17", "SIGTERM, SIGINT", {.brief = 4, .stated = 50});
    while (row.next()) {
        Case c(scene(", nap: 0.001", ""));
        shell::Background run(c.command(), c.log());
        for (int tries = 0; tries < 4000 && child_of(run.pid(), "right") == 0; ++tries)
            std::this_thread::sleep_for(milliseconds(1));
        std::this_thread::sleep_for(random_time(1400));
        int const participant = child_of(run.pid(), row.round() % 2 ? "left" : "right");
        bool const to_launcher = row.round() % 4 < 2;
        if (to_launcher)
            run.signal(row.round() % 4 == 0 ? SIGTERM : SIGINT);
        else if (participant > 0)
            ::kill(participant, SIGTERM);
        auto const result = run.wait(60);
        row.took(result.seconds, 20.0);
        // before there are windows there is nothing to store: interrupted, or as one that died
        CAPTURE(result.exit);
        CAPTURE(result.output);
        bool const early = result.exit == 130 || (!to_launcher && result.exit == 3);
        CHECK((result.exit == 0 || result.exit == 75 || early));
        if (early) CHECK(has(first_line(result), "before its first window"));
        CHECK(c.leftovers() == 0);
        if (result.exit != 75) continue;
        ++stopped;
        CHECK(c.checkpoints().size() == 1);
        check_resumes(c);
        CHECK(end_of(c) == whole);
    }
    MESSAGE("F17: " << stopped << " of " << row.repeats()
                    << " stopped with a checkpoint, each went on to the same bits");
}

TEST_CASE("F18: SIGKILL of the launcher, or a second SIGTERM: no process is left")
{
    Row row("F18", "SIGKILL of the launcher, second SIGTERM", {.brief = 4, .stated = 20});
    while (row.next()) {
        bool const kill = row.round() % 2 == 0;
        auto const transport = row.round() / 2 % 2 == 0 ? "auto" : "mpi";
        Case c(scene(", nap: 0.002", kill ? "" : ", fault: hang, fault_window: 30", "checkpoint: {windows: 10}\n"));
        shell::Background run(c.command({"--set", std::string("transport=") + transport}), c.log());
        REQUIRE(c.pid_in_window("right", 30) > 0);
        if (!kill) {
            run.signal(SIGTERM);
            std::this_thread::sleep_for(milliseconds(200));
        }
        auto const begin = std::chrono::steady_clock::now();
        run.signal(kill ? SIGKILL : SIGTERM);
        auto const result = run.wait(30);
        CHECK(result.exit == (kill ? 128 + SIGKILL : 130));
        if (!kill) CHECK(has(result.output, "\"right\" in window 30 of 1000 (t = 0.03 s)"));
        auto const passed = [&] {
            return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
        };
        while (c.leftovers() > 0 && passed() < 30) std::this_thread::sleep_for(milliseconds(5));
        row.took(passed(), 1.0);
        CHECK(c.leftovers() == 0);
        check_resumes(c);
    }
}

TEST_CASE("F19: a number that is not finite is refused before it is delivered, with participant, field, id and window")
{
    Row row("F19", "NaN in an exchanged field", {.brief = 2, .stated = 20});
    while (row.next()) {
        std::string const victim = row.round() % 2 ? "left" : "right";
        auto const window = std::to_string(100 + 7 * row.round());
        auto const fault = ", fault: nan, fault_window: " + window;
        Case c(scene(victim == "left" ? fault : "", victim == "left" ? "" : fault, "checkpoint: {windows: 50}\n"));
        auto const result = c.run();
        check_fatal(c, result, 6, victim,
                    "place.place of id 1 is not finite in frame " + std::to_string(101 + 7 * row.round()));
        CHECK(has(first_line(result), "in window " + window + " of 1000"));
        check_resumes(c);
    }
}

TEST_CASE("F20: no memory within a limit of its own: said, with the participant's name")
{
    Row row("F20", "bad_alloc under RLIMIT_AS", {.brief = 2, .stated = 20});
    while (row.next()) {
        std::string const victim = row.round() % 2 ? "to" : "from", grows = "says: 1, grows: 20000000";
        Case c(stream_scene(victim == "from" ? grows : "nap: 0.001", victim == "from" ? "nap: 0.001" : grows,
                            "checkpoint: {windows: 10}\n", "0.5"));
        auto const result = bash(c, "ulimit -v 1200000; exec " + joined(c.command()));  // kB; 500 windows need 10 GB
        row.took(age_of(c.out() + "/" + victim + ".log"), 1.0);                         // since its last words
        check_fatal(c, result, 7, victim, "out of memory");
        REQUIRE(!c.checkpoints().empty());
        check_resumes(c);  // the toy grows only once
    }
}

namespace {

//! A control group for memory, version 1 or 2, with a limit; needs root.
class MemoryGroup
{
 public:
    explicit MemoryGroup(long bytes)
    {
        for (std::string const root : {"/sys/fs/cgroup/memory", "/sys/fs/cgroup"}) {
            auto const group = root + "/sluice-test-" + std::to_string(::getpid());
            if (!std::filesystem::exists(root + "/cgroup.procs") || ::mkdir(group.c_str(), 0755) != 0) continue;
            folder_ = group;
            for (std::string const key : {"memory.limit_in_bytes", "memory.max"})
                if (std::filesystem::exists(group + "/" + key)) ready_ = put(key, std::to_string(bytes));
            put("memory.swap.max", "0");
            if (ready_) return;
            ::rmdir(group.c_str());
        }
    }
    MemoryGroup(MemoryGroup const&) = delete;
    MemoryGroup& operator=(MemoryGroup const&) = delete;
    ~MemoryGroup()
    {
        if (ready_) ::rmdir(folder_.c_str());
    }
    bool ready() const { return ready_; }
    std::string processes() const { return folder_ + "/cgroup.procs"; }

 private:
    bool put(std::string const& key, std::string const& value) const
    {
        std::ofstream file(folder_ + "/" + key);
        file << value;
        return static_cast<bool>(file.flush());
    }
    std::string folder_;
    bool ready_ = false;
};

}  // namespace

TEST_CASE("F20: ended by the kernel's out-of-memory killer: said, with the participant's name")
{
    MemoryGroup const group(400'000'000);
    if (!group.ready()) {
        MESSAGE("skipped: no memory control group can be made here (needs root and a writable /sys/fs/cgroup)");
        return;
    }
    Row row("F20", "cgroup OOM kill", {.brief = 1, .stated = 20});
    while (row.next()) {
        std::string const victim = row.round() % 2 ? "to" : "from", grows = "says: 1, grows: 10000000";
        Case c(stream_scene(victim == "from" ? grows : "nap: 0.001", victim == "from" ? "nap: 0.001" : grows,
                            "checkpoint: {windows: 5}\n", "0.5"));
        auto const result = bash(c, "echo $$ >" + group.processes() + "; exec " + joined(c.command()));
        row.took(age_of(c.out() + "/" + victim + ".log"), 1.0);
        check_fatal(c, result, 3, victim, "was ended by signal 9");
        REQUIRE(!c.checkpoints().empty());
        check_resumes(c);  // the toy grows only once
    }
}
