// Participants in C and Python: the same bits as in C++, clear ends after every misuse, checkpoints, no copies.

#include <doctest/doctest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "coupler/base/status_page.hpp"
#include "tests/support/scratch.hpp"
#include "tests/support/shell.hpp"

namespace {

std::string const cpp = SPRING_CPP, c = SPRING_C, python = "/usr/bin/python3, " SPRING_PY,
                  faulty = "/usr/bin/python3, " FAULTY;

//! Two springs, 1 s in 200 windows.
struct Case
{
    Case(std::string const& left, std::string const& right, std::string const& fault = "none",
         std::string const& more = "")
    {
        ::setenv("PYTHONPATH", MODULE_FOLDER, 1);
        std::ofstream(file()) << "sluice: 1\ntime: {end: 1, window: 0.005}\n"
                                 "data: {place: {columns: {place: {unit: m}}}}\nparticipants:\n  left: {command: [" +
                                     left + "], config: {start: 1" + (fault == "none" ? "" : ", fault: " + fault) +
                                     more + "}}\n  right: {command: [" + right +
                                     "], config: {start: 0}}\ncouplings:\n  - {from: left, to: right, data: place}\n"
                                     "  - {from: right, to: left, data: place, lag: 1, predict: linear}\n";
    }
    std::string file() const { return scratch.path() / "scene.yaml"; }
    std::string out() const { return scratch.path() / "out"; }
    shell::Result run() const
    {
        return shell::run({SLUICE_COMMAND, "run", file(), "--out", out(), "--no-report", "--quiet"},
                          scratch.path() / "log");
    }
    //! What a Python spring is started with by hand.
    std::vector<std::string> by_hand(std::string const& name, bool resumed) const
    {
        std::vector<std::string> words{"/usr/bin/python3", FAULTY, file(), "--as", name, "--out", out()};
        if (resumed) words.emplace_back("--resume");
        return words;
    }
    double fact(std::string const& name, std::string const& what = "place at the end [m]") const
    {
        auto const said = nlohmann::json::parse(shell::slurp(out() + "/.sluice/" + name + ".json"), nullptr, false);
        return said.is_object() ? said.at("facts").value(what, std::nan("")) : std::nan("");
    }
    in_threads::Scratch scratch;
};

bool says(std::string const& output, std::string const& text)
{
    bool const found = output.find(text) != std::string::npos;
    if (!found) MESSAGE("\"" << text << "\" is not in the output: " << output);
    return found;
}

}  // namespace

TEST_CASE("bindings: at most 25 functions, and nothing else, can be seen in the library")
{
    in_threads::Scratch scratch;
    auto const result = shell::run({"/usr/bin/nm", "-D", "--defined-only", LIBRARY}, scratch.path() / "log");
    REQUIRE(result.exit == 0);
    std::istringstream lines(result.output);
    int functions = 0;
    for (std::string address, kind, name; lines >> address >> kind >> name; ++functions) {
        CHECK(kind == "T");
        CHECK(name.starts_with("sluice_"));
    }
    CHECK(functions > 20);
    CHECK(functions <= 25);
}

TEST_CASE("bindings: springs in C and Python, with each other and with C++, give the bits of C++")
{
    Case const reference(cpp, cpp);
    REQUIRE(reference.run().exit == 0);
    REQUIRE(std::isfinite(reference.fact("left")));
    for (auto const& [left, right] :
         {std::pair(c, c), {python, python}, {c, cpp}, {cpp, c}, {python, cpp}, {cpp, python}, {python, c}}) {
        CAPTURE(left);
        CAPTURE(right);
        Case const mixed(left, right);
        auto const result = mixed.run();
        if (result.exit != 0) MESSAGE(result.output);
        CHECK(result.exit == 0);
        for (auto const name : {"left", "right"}) CHECK(mixed.fact(name) == reference.fact(name));
    }
}

TEST_CASE("bindings: misuse ends with the exit code and words that name it, and the partner hears them")
{
    struct Misuse
    {
        char const* fault;
        int exit;
        char const* words;
    };
    for (auto const& [fault, exit, words] : {
             Misuse{"nan", 6, "place.place of id 0 is not finite"},
             Misuse{"float32", 70, "write of place.place: float32 (needed: float64)"},
             Misuse{"int ids", 70, "write of place: ids: int32 (needed: int64)"},
             Misuse{"list", 70, "write of place.place: a list (needed: a numpy array of float64)"},
             Misuse{"shape", 70, "write of place.place: shape (1, 2) (needed: (1,) or (1, 1))"},
             Misuse{"points", 70, "write of place.place: shape (2,) (needed: (1,)"},
             Misuse{"strided", 70, "write of place.place: not contiguous"},
             Misuse{"no column", 70, "wrote place with plaice (its columns: place)"},
             Misuse{"no partner", 70, "writes place to \"nobody\", but the scene has no such coupling"},
             Misuse{"no data", 70, "reads load from \"right\", but the scene has no such coupling"},
             Misuse{"read before", 70, "sluice_read: no window is being computed"},
             Misuse{"outside", 70, "is not in the window (0.015000 to 0.020000 s)"},
             Misuse{"old samples", 70, "sluice_read: t = 0.010000 s is not in the window"},
             Misuse{"twice", 70, "wrote place twice in window 3"},
             Misuse{"no write", 70, "wrote nothing to \"right\""},
             Misuse{"no write before", 70, "wrote nothing to \"right\""},
             Misuse{"stale", 70, "writes place to \"nobody\""},
             Misuse{"go on", 70, "writes place to \"nobody\""},
             Misuse{"raise", 70, "ValueError: grain 7 is gone (faulty.py:"},
             Misuse{"exit", 70, "SystemExit: 0"},
             Misuse{"memory", 7, "\"left\": out of memory"},
             Misuse{"interrupt", 130, "\"left\": interrupted from the keyboard"},
             Misuse{"refuse", 2, "scene.yaml:5:"},
         }) {
        CAPTURE(fault);
        Case const wrong(faulty, cpp, fault);
        auto const result = wrong.run();
        CHECK(result.exit == exit);
        CHECK(says(result.output, words));
        if (std::string(fault) == "raise") CHECK(says(result.output, "in solve"));  // a traceback
    }
}

TEST_CASE("bindings: mistakes of the config are listed with their places")
{
    Case const wrong(faulty, cpp, "none", ", nap: fast, flag: 3, list: [1, 2], naap: 1");
    auto const result = wrong.run();
    CHECK(result.exit == 2);
    for (auto const words : {"config.nap = fast", "config.flag = 3", "config.list", "naap is not a key"})
        CHECK(says(result.output, words));
}

TEST_CASE("bindings: windows, the end and checkpoints by who paces the run")
{
    Case const longer(faulty, cpp, "pace");
    CHECK(longer.run().exit == 0);
    CHECK(longer.fact("left", "windows seen") == 102);  // 4 of 5 ms, then 0.98 s in windows of 10 ms
    Case const ended(faulty, cpp, "end");
    CHECK(ended.run().exit == 0);
    CHECK(ended.fact("left", "windows seen") == 5);
    Case const kept(faulty, faulty, "checkpoint");
    CHECK(kept.run().exit == 0);
    CHECK(std::filesystem::exists(kept.out() + "/checkpoints"));
    Case const failed(faulty, faulty, "save", "");
    std::ofstream(failed.file(), std::ios::app) << "checkpoint: {windows: 5}\n";
    auto const result = failed.run();
    CHECK(result.exit == 70);
    CHECK(says(result.output, "ValueError: no state today"));
}

TEST_CASE("bindings: Python springs in an implicit group repeat windows and move as if they were one program")
{
    Case const group(faulty, faulty);
    std::ofstream(group.file(), std::ios::app) << "implicit: [{participants: [left, right], tolerance: 1e-10}]\n";
    auto const result = group.run();
    REQUIRE(result.exit == 0);
    double x[] = {1, 0}, v[] = {0, 0};  // both masses by the springs' own scheme, each at its partner's true place
    auto const kick = [&] {
        for (int k : {0, 1}) v[k] += 0.0025 * (-39.5 * x[k] - 157.9 * (x[k] - x[1 - k]));
    };
    for (int n = 0; n < 200; ++n) {
        kick();
        for (int k : {0, 1}) x[k] += 0.005 * v[k];
        kick();
    }
    // An error of 1e-10 m of the partner's place in each of 200 windows changes a velocity by 157.9 * 0.005 / 2 of it,
    // and a place by at most that over the frequency of 2 pi: 1.3e-9 m
    CHECK(std::abs(group.fact("left") - x[0]) < 1.3e-9);
    CHECK(std::abs(group.fact("right") - x[1]) < 1.3e-9);
    CHECK(group.fact("left", "windows seen") == 200);
    CHECK(group.fact("left", "windows repeated") >= 200);
}

TEST_CASE("bindings: a library of another interface is refused, from both sides")
{
    in_threads::Scratch scratch;
    ::setenv("PYTHONPATH", MODULE_FOLDER, 1);
    auto const python_runs = [&](std::string const& text) {
        return shell::run({"/usr/bin/python3", "-c", text}, scratch.path() / "log");
    };
    auto const older = python_runs("import sluice\nsluice.ABI += 1\nsluice.run(None, ['x'])");
    CHECK(older.exit == 5);
    CHECK(says(older.output, "with interface 1, this file needs 2 (must match)"));
    auto const c_side = python_runs(
        "import ctypes, sluice\n"
        "library = sluice._load()\nself = ctypes.c_void_p(7)\n"
        "status = library.sluice_join(sluice.ABI + 1, 0, None, ctypes.byref(self))\n"
        "print(status, self.value, library.sluice_error(None).decode())\n"
        "words = (ctypes.c_char_p * 1)(b'x')\n"
        "status = library.sluice_join(sluice.ABI + 1, 1, words, ctypes.byref(self))\n"
        "print(status, self.value, library.sluice_error(None).decode())\n"
        "print('null', library.sluice_fact(None, b'x', ctypes.c_double(1)), library.sluice_error(None).decode())\n"
        "library.sluice_leave(None, 5, None)");
    CHECK(c_side.exit == 0);
    CHECK(says(c_side.output, "70 None sluice_join: argv is NULL"));
    CHECK(says(c_side.output, "5 None libsluice_c has interface 1, the program was made for 2 (must match)"));
    CHECK(says(c_side.output, "null 70 sluice_fact: the participant is NULL"));
    ::setenv("SLUICE_LIBRARY", "/nowhere/libsluice_c.so", 1);
    auto const lost = python_runs("import sluice\nsluice.run(None, ['x'])");
    ::unsetenv("SLUICE_LIBRARY");
    CHECK(lost.exit == 7);
    CHECK(says(lost.output, "set SLUICE_LIBRARY to the file"));
    CHECK(python_runs("import sluice\nsluice.run(None, ['x', '--help'])").exit == 0);
    CHECK(python_runs("import sluice\nsluice.run(None, ['x'])").exit == 2);
    auto const no_scene = python_runs("import sluice\nsluice.run(None, ['x', 'none.yaml', '--as', 'y'])");
    CHECK(no_scene.exit == 2);
    CHECK(says(no_scene.output, "none.yaml"));
}

TEST_CASE("bindings: Python springs stop by SIGTERM with a checkpoint and go on, by hand, to the same bits")
{
    Case const whole(faulty, faulty);
    REQUIRE(whole.run().exit == 0);
    Case const stopped(faulty, faulty, "none", ", nap: 0.02");
    {
        shell::Background left(stopped.by_hand("left", false), stopped.scratch.path() / "left");
        shell::Background right(stopped.by_hand("right", false), stopped.scratch.path() / "right");
        auto const page = sluice::status_file(stopped.out(), "left");
        bool running = false;
        for (int tries = 0; tries < 6000 && !running; ++tries) {
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
            std::error_code none;
            if (std::filesystem::file_size(page, none) != sizeof(sluice::StatusPage)) continue;
            sluice::MappedStatus const status(page, sluice::MappedStatus::Mode::open);
            running = status->phase == sluice::Phase::running && status->window >= 20;
        }
        REQUIRE(running);
        left.signal(SIGTERM);
        for (auto* const process : {&left, &right}) {
            auto const result = process->wait(60);
            CHECK(result.exit == 75);
            if (result.exit != 75) MESSAGE(result.output);
        }
        CHECK(stopped.fact("left", "windows seen") < 200);
    }
    shell::Background left(stopped.by_hand("left", true), stopped.scratch.path() / "left");
    shell::Background right(stopped.by_hand("right", true), stopped.scratch.path() / "right");
    for (auto* const process : {&left, &right}) {
        auto const result = process->wait(60);
        CHECK(result.exit == 0);
        if (result.exit != 0) MESSAGE(result.output);
    }
    for (auto const name : {"left", "right"}) {
        CHECK(stopped.fact(name) == whole.fact(name));
        CHECK(stopped.fact(name, "windows seen") == 200);
    }
}

TEST_CASE("bindings: what Python reads and writes is the library's memory and its own")
{
    Case const run(faulty, cpp, "same memory");
    auto const result = run.run();
    CHECK(result.exit == 0);
    if (result.exit != 0) MESSAGE(result.output);
    CHECK(run.fact("left", "same memory") == 1);
}
