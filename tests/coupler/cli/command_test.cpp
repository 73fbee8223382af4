// The command as a user types it: answers, exit codes, JSON.

#include <doctest/doctest.h>

#include <nlohmann/json.hpp>

#include "coupler/base/status_page.hpp"
#include "tests/support/close_to.hpp"
#include "tests/support/run_in_threads.hpp"
#include "tests/support/shell.hpp"

namespace {

using Json = nlohmann::json;
using Words = std::vector<std::string>;

//! A directory of its own for a test, and the command run in it.
struct Desk
{
    in_threads::Scratch scratch;
    std::string at(std::string const& name) const { return scratch.path() / name; }
    shell::Result sluice(Words words) const
    {
        words.insert(words.begin(), SLUICE_COMMAND);
        return shell::run(words, scratch.path() / "said");
    }
    Json json(Words const& words) const
    {
        auto const result = sluice(words);
        auto const answer = Json::parse(result.output, nullptr, false);
        if (answer.is_discarded()) MESSAGE("not JSON: " << result.output);
        REQUIRE_FALSE(answer.is_discarded());
        return answer;
    }
    void write(std::string const& name, std::string const& text) const { std::ofstream(at(name)) << text; }
};

bool says(shell::Result const& result, std::string const& text)
{
    bool const found = result.output.find(text) != std::string::npos;
    if (!found) MESSAGE("not in: " << result.output);
    return found;
}

//! Two masses and a spring, 200 windows; a scene that runs in no time.
std::string const scene =
    "sluice: 1\ntime: {end: 0.2, window: 0.001}\ndata: {place: {columns: {place: {unit: m}}}}\nparticipants:\n"
    "  left: {command: " TOY_COMMAND
    ", config: {mass: 1, wall_spring: 39, middle_spring: 158, place: 1}}\n"
    "  right: {command: " TOY_COMMAND
    ", config: {mass: 1, wall_spring: 39, middle_spring: 158, place: 0}}\n"
    "couplings:\n  - {from: left, to: right, data: place}\n  - {from: right, to: left, data: place, lag: 1}\n";

//! A participant's page as a run leaves it.
sluice::MappedStatus page(Desk const& desk, std::string const& name, sluice::Phase phase, std::int64_t window)
{
    std::filesystem::create_directories(desk.at(".sluice"));
    sluice::MappedStatus status(sluice::status_file(desk.scratch.path(), name), sluice::MappedStatus::Mode::create);
    status->pid = ::getpid();
    status->windows = 100;
    status->window = window;
    status->time = 0.01 * static_cast<double>(window);
    status->compute_ns = 3'000'000'000;
    status->wait_ns = 1'000'000'000;
    status->phase = phase;
    return status;
}

}  // namespace

TEST_CASE("command: misspelt commands and options get the nearest, exit 2")
{
    Desk const desk;
    for (auto const& [words, advice] : std::vector<std::pair<Words, std::string>>{
             {{"chekc", "x"}, "\"chekc\" is not a command. Did you mean check?"},
             {{"check", "--sett", "a=b", "x"}, "--sett is not an option of sluice check. Did you mean --set?"},
             {{"run", "--quite", "x"}, "Did you mean --quiet?"},
             {{"watch", "--jsn", "x"}, "Did you mean --json?"},
             {{"--versoin"}, "--versoin is not an option of sluice. Did you mean --version?"}}) {
        auto const result = desk.sluice(words);
        CHECK(result.exit == 2);
        CHECK(says(result, advice));
    }
    CHECK(desk.sluice({}).exit == 2);
    CHECK(desk.sluice({"check"}).exit == 2);
    CHECK(desk.sluice({"--help"}).exit == 0);
}

TEST_CASE("command: explain knows every exit code and finds messages by a word")
{
    Desk const desk;
    for (char const* code : {"0", "2", "3", "4", "5", "6", "7", "8", "70", "75", "130"}) {
        auto const answer = desk.json({"explain", code, "--json"});
        REQUIRE(answer.size() == 1);
        CHECK(answer[0]["exit"] == std::stoi(code));
    }
    CHECK(says(desk.sluice({"explain"}), "a participant ended before the run did"));
    CHECK(says(desk.sluice({"explain", "circle"}), "lag: 1"));
    CHECK(says(desk.sluice({"explain", "resume"}), "75 (stopped)"));
    auto const unknown = desk.sluice({"explain", "circel"});
    CHECK(unknown.exit == 2);
    CHECK(says(unknown, "Did you mean circle?"));
}

TEST_CASE("command: explain takes a message as it was printed")
{
    struct
    {
        std::string message, word;
    } const said[] = {
        {"scene.yaml:8:1: participants.left.colour is not a key (keys: command, config, ranks).", "key"},
        {"participant \"left\" is lost: its process 12 ended, while \"right\" was in window 3 of 5 (t = 0.1 s). Look "
         "at its log.",
         "lost"},
        {"participant \"a\": \"b\" (it does not listen yet) did not come within 60 s. Start with:", "absent"},
        {"participants \"a\" and \"b\" have different scenes: \"x = 1\" here, \"x = 2\" there.", "scenes"},
        {"participant \"left\": place.place of id 1 is not finite in frame 301", "finite"},
        {"ledger, in window 5 of 9 (t = 1 s): a -> b: load: force_x [N] does not close: 1 times seconds came",
         "ledger"},
        {"participant \"a\" wrote nothing to \"b\" before window 1 of 2", "written"},
        {"out: no complete checkpoint to go on from. ", "checkpoint"},
        {"window 12 did not converge in 20 iterations (relative residuals: x 0.1).", "converge"},
        {"out/series.csv: cannot write: No space left on device (errno 28). Free some space, or choose another folder.",
         "space"}};
    Desk const desk;
    for (auto const& [message, word] : said) {
        CAPTURE(message);
        auto const answer = desk.json({"explain", message, "--json"});
        REQUIRE(answer.size() == 1);
        CHECK(answer[0]["word"] == word);
    }
    CHECK(desk.sluice({"explain", "this was never printed"}).exit == 2);
}

TEST_CASE("command: check says how the schedule goes, and warns")
{
    Desk const desk;
    desk.write("scene.yaml", scene);
    auto const answer = desk.json({"check", desk.at("scene.yaml"), "--json"});
    CHECK(answer["ok"] == true);
    CHECK(answer["schedule"]["computations_per_window"] == 2);
    CHECK(answer["schedule"]["critical"] == Json{"left", "right"});
    CHECK(answer["warnings"].empty());
    CHECK(says(desk.sluice({"check", desk.at("scene.yaml")}), "one after the other in a window: left -> right"));
    auto const uneven = desk.sluice({"check", desk.at("scene.yaml"), "--set", "time.window=0.0007"});
    CHECK(uneven.exit == 0);
    CHECK(says(uneven, "is no whole number of windows"));
    auto text = scene;
    text.replace(text.find("unit: m}"), 8, "unit: mm}");
    desk.write("mm.yaml", text);
    CHECK(says(desk.sluice({"check", desk.at("mm.yaml")}),
               "mm.yaml:3:40: data.place.columns.place.unit = mm is accepted, but mm is not SI (needed: m)"));
    CHECK(desk.json({"check", desk.at("mm.yaml"), "--json"})["warnings"][0]["line"] == 3);
}

TEST_CASE("command: check knows the window, and that the lattice cannot do a part of its step")
{
    Desk const desk;
    CHECK(desk.sluice({"init", "immersed_column", desk.at("in")}).exit == 0);
    auto const file = desk.at("in/scene.yaml");
    CHECK(says(desk.sluice({"check", file}), "15000 windows of 2e-05 s"));
    CHECK(desk.json({"check", file, "--json"})["window_seconds"] == close_to(2e-5));
    CHECK(desk.sluice({"check", file, "--set", "time.window=1e-4"}).exit == 0);
    auto text = shell::slurp(file);
    text.replace(text.find("window: auto"), 12, "window: 3e-5");
    desk.write("bad.yaml", text);
    auto const result = desk.sluice({"check", desk.at("bad.yaml")});
    CHECK(result.exit == 2);
    CHECK(
        says(result,
             "bad.yaml:8:18: time.window = 3e-05 s is no whole number of the steps of \"water\" (2e-05 s). Use auto."));
}

TEST_CASE("command: check of a circle says who waits for what of whom")
{
    Desk const desk;
    auto text = scene;
    text.erase(text.find(", lag: 1"), 8);
    desk.write("scene.yaml", text);
    auto const result = desk.sluice({"check", desk.at("scene.yaml")});
    CHECK(result.exit == 2);
    CHECK(says(result, "scene.yaml:7:1: couplings: the lag-0 edges form a circle"));
    CHECK(says(result, "deadlock: left waits in window 0 for frame 1 of place from right"));
    CHECK(desk.json({"check", desk.at("scene.yaml"), "--json"})["waits"].size() == 2);
}

TEST_CASE("command: a scene that is not there, and one that is no text, are mistakes in JSON too")
{
    Desk const desk;
    auto const answer = desk.json({"check", desk.at("nothing.yaml"), "--json"});
    CHECK(answer["ok"] == false);
    CHECK(answer["mistakes"].size() == 1);
}

TEST_CASE("command: graph --json has who sends what to whom")
{
    Desk const desk;
    desk.write("scene.yaml", scene);
    auto const answer = desk.json({"graph", desk.at("scene.yaml"), "--json"});
    CHECK(answer["participants"].size() == 2);
    CHECK(answer["couplings"][1]["from"] == "right");
    CHECK(answer["couplings"][1]["lag"] == 1);
    CHECK(answer["couplings"][0]["columns"][0]["unit"] == "m");
}

TEST_CASE("command: run --json prints the summary, and report --json the files")
{
    Desk const desk;
    desk.write("scene.yaml", scene);
    auto const answer =
        desk.json({"run", desk.at("scene.yaml"), "--out", desk.at("out"), "--no-report", "--quiet", "--json"});
    CHECK(answer["exit"] == 0);
    CHECK(answer["windows"] == 200);
    CHECK(answer == Json::parse(shell::slurp(desk.at("out/summary.json"))));
    auto const report = desk.json({"report", desk.at("out"), "--json"});
    CHECK(std::filesystem::file_size(report["page"].get<std::string>()) > 1000);
    auto const& files = report["runs"][0]["files"];
    CHECK(std::any_of(files.begin(), files.end(), [](Json const& f) { return f["file"] == "summary.json"; }));
    CHECK(std::none_of(files.begin(), files.end(),
                       [](Json const& f) { return f["file"].get<std::string>().starts_with(".sluice"); }));
    auto const watched = desk.json({"watch", desk.at("out"), "--json"});
    CHECK(watched["participants"][0]["phase"] == "done");
    CHECK(watched["participants"][0]["window"] == 200);
}

TEST_CASE("command: watch shows the pages, and ends with the run and its code")
{
    Desk const desk;
    auto const left = page(desk, "left", sluice::Phase::running, 25);
    auto right = page(desk, "right", sluice::Phase::running, 24);
    auto const state = desk.json({"watch", desk.scratch.path(), "--once", "--json"});
    auto const& first = state["participants"][0];
    CHECK(first["name"] == "left");
    CHECK(first["phase"] == "running");
    CHECK(first["windows"] == 100);
    CHECK(first["to_go_seconds"] == close_to(12.0));  // 4 s for 25 of 100 windows
    CHECK(says(desk.sluice({"watch", desk.scratch.path(), "--once"}), "25/100"));
    shell::Background watch({SLUICE_COMMAND, "watch", desk.scratch.path()}, desk.at("watched"));
    CHECK(watch.wait(1.5).exit == -1);  // goes on while the run does
    left->phase = sluice::Phase::failed;
    left->consequence = 1;
    left->exit = 3;
    right.fail("right: blew up.", 6, false);
    auto const ended = watch.wait(60);
    CHECK(ended.exit == 6);
    CHECK(says(ended, "right: blew up."));
}

TEST_CASE("command: watch of a run that was stopped with a checkpoint ends with 75")
{
    Desk const desk;
    auto const left = page(desk, "left", sluice::Phase::done, 40);
    left->exit = 75;
    left->checkpoint = 40;
    auto const result = desk.sluice({"watch", desk.scratch.path(), "--json"});
    CHECK(result.exit == 75);
    CHECK(Json::parse(result.output)["participants"][0]["checkpoint"] == 40);
}

TEST_CASE("command: watch of a directory without a run is exit 7")
{
    Desk const desk;
    auto const result = desk.sluice({"watch", desk.scratch.path()});
    CHECK(result.exit == 7);
    CHECK(says(result, "nobody has started there"));
}

TEST_CASE("command: init makes scenes that check, and never overwrites")
{
    Desk const desk;
    for (char const* name : {"dry_column", "immersed_column"}) {
        CAPTURE(name);
        CHECK(desk.sluice({"init", name, desk.at(name)}).exit == 0);
        auto const scene_file = desk.at(name) + "/scene.yaml";
        CHECK(shell::slurp(scene_file).starts_with("# yaml-language-server: $schema=./scene.schema.json\n"));
        CHECK(Json::parse(shell::slurp(desk.at(name) + "/scene.schema.json")).contains("properties"));
        auto const check = desk.sluice({"check", scene_file});
        CHECK(check.exit == 0);
        if (check.exit != 0) MESSAGE(check.output);
        auto const again = desk.sluice({"init", name, desk.at(name)});
        CHECK(again.exit == 7);
        CHECK(says(again, "nothing is overwritten"));
    }
    CHECK(desk.sluice({"init"}).output == "dry_column\nimmersed_column\ntwo_solvers\n");
    CHECK(desk.sluice({"init", "dry_colum", desk.at("x")}).exit == 2);
}

TEST_CASE("command: init two_solvers makes a participant that builds and runs")
{
    Desk const desk;
    CHECK(desk.sluice({"init", "two_solvers", desk.at("two")}).exit == 0);
    std::filesystem::create_directories(desk.at("two/build"));
    std::filesystem::copy(TEMPLATE_SPRING, desk.at("two/build/spring"));  // built from the template's own source
    auto const command = "command=" + desk.at("two/build/spring");
    auto const result = desk.sluice({"run", desk.at("two/scene.yaml"), "--out", desk.at("out"), "--no-report", "--set",
                                     "participants.left." + command, "--set", "participants.right." + command});
    CHECK(result.exit == 0);
    if (result.exit != 0) MESSAGE(result.output);
}

TEST_CASE("command: doctor names what it looked at, and its exit code says whether something must be repaired")
{
    Desk const desk;
    auto const result = desk.sluice({"doctor", "--json"});
    auto const answer = Json::parse(result.output);
    CHECK(result.exit == (answer["ok"] ? 0 : 7));
    std::vector<std::string> looked_at;
    for (auto const& f : answer["findings"]) {
        looked_at.push_back(f["what"]);
        bool const known = f["state"] == "ok" || f["state"] == "warn" || f["state"] == "fail";
        CHECK(known);
        CHECK((f["state"] == "ok") == (f["advice"] == ""));
    }
    CHECK(looked_at == std::vector<std::string>{"sluice", "libraries", "solvers", "mpi", "shared memory", "open files",
                                                "locked memory", "python", "graphviz", "clock", "cores", "cache"});
}

TEST_CASE("command: doctor warns where there is nothing, and says what to install")
{
    Desk const desk;
    auto const result = shell::run({"/usr/bin/env", "-i", "PATH=/nowhere", SLUICE_COMMAND, "doctor"}, desk.at("said"));
    CHECK(says(result, "install openmpi-bin"));
    CHECK(says(result, "install graphviz"));
    CHECK(says(result, "set SLUICE_CACHE"));
}

TEST_CASE("command: schema goes to a file, and knows the paths of --set")
{
    Desk const desk;
    desk.write("scene.yaml", scene);
    CHECK(desk.sluice({"schema", "-o", desk.at("s.json")}).exit == 0);
    CHECK(Json::parse(shell::slurp(desk.at("s.json"))) == desk.json({"schema"}));
    auto const paths = desk.sluice({"schema", "--paths", desk.at("scene.yaml")}).output;
    CHECK(paths.find("couplings.1.lag\n") != paths.npos);
    CHECK(paths.find("checkpoint.interval") == paths.npos);  // its mapping is not in the scene
    std::istringstream lines(paths);
    int tried = 0;
    for (std::string path; std::getline(lines, path); ++tried) {
        auto const result = desk.sluice({"graph", desk.at("scene.yaml"), "--set", path + "=1"});
        CHECK(result.output.find("is not in the scene") == std::string::npos);
    }
    CHECK(tried > 20);
}
