#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <thread>

#include "coupler/base/error.hpp"
#include "coupler/base/status_page.hpp"
#include "coupler/cli/answers.hpp"
#include "coupler/cli/commands.hpp"

namespace sluice {
namespace {

using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

constexpr auto between_looks = std::chrono::milliseconds(500);
constexpr auto still_for = std::chrono::seconds(3);  // a page that stands still this long and has no process: it ended

//! One participant's page and when it last changed.
struct Watched
{
    std::string name;
    MappedStatus page;
    std::int64_t window = -1;
    Clock::time_point changed = Clock::now();

    void look()
    {
        if (page->window != window) changed = Clock::now();
        window = page->window;
    }
    bool failed() const { return page->phase == Phase::failed; }
    bool gone() const
    {
        bool const no_process = page->pid > 0 && ::kill(page->pid, 0) != 0 && errno == ESRCH;
        return no_process && Clock::now() - changed > still_for;  // on another host there never is one
    }
    bool ended() const { return page->phase == Phase::done || failed() || gone(); }
};

std::vector<Watched> pages_of(std::filesystem::path const& run)
{
    std::vector<Watched> found;
    std::error_code none;
    for (auto const& entry : std::filesystem::directory_iterator(run / ".sluice", none)) {
        if (entry.path().extension() != ".status") continue;
        Watched watched{entry.path().stem().string(), MappedStatus(entry.path(), MappedStatus::Mode::open)};
        if (watched.page) found.push_back(std::move(watched));
    }
    std::sort(found.begin(), found.end(), [](Watched const& a, Watched const& b) { return a.name < b.name; });
    return found;
}

//! Maps the pages anew: a run that is started again has new ones under the old names.
void refresh(std::vector<Watched>& all, std::filesystem::path const& run)
{
    auto now = pages_of(run);
    for (auto& w : now)
        for (auto const& old : all)
            if (old.name == w.name) {
                w.window = old.window;
                w.changed = old.changed;
            }
    if (!now.empty()) all = std::move(now);
}

char const* word_of(Watched const& w)
{
    constexpr char const* words[] = {"absent", "preparing", "connecting", "running", "done", "failed"};
    return w.page->phase != Phase::done && !w.failed() && w.gone() ? "gone"
                                                                   : words[static_cast<int>(w.page->phase.load())];
}

std::string note_of(Watched const& w)
{
    if (w.failed()) return {w.page->message, strnlen(w.page->message, sizeof w.page->message)};
    return {w.page->note, strnlen(w.page->note, sizeof w.page->note)};
}

Json as_json(Watched const& w)
{
    auto const& p = w.page;
    double const compute = 1e-9 * static_cast<double>(p->compute_ns), wait = 1e-9 * static_cast<double>(p->wait_ns),
                 exchange = 1e-9 * static_cast<double>(p->exchange_ns);
    Json entry = {{"name", w.name},
                  {"phase", word_of(w)},
                  {"window", p->window.load()},
                  {"windows", p->windows.load()},
                  {"time", p->time.load()},
                  {"compute_seconds", compute},
                  {"wait_seconds", wait},
                  {"exchange_seconds", exchange}};
    auto const window = static_cast<double>(p->window);
    double const left = static_cast<double>(p->windows) - window;
    if (p->phase == Phase::running && window > 0) entry["to_go_seconds"] = (compute + wait + exchange) / window * left;
    if (auto const note = note_of(w); !note.empty()) entry["note"] = note;
    if (p->checkpoint >= 0) entry["checkpoint"] = p->checkpoint.load();
    if (p->exit >= 0) entry["exit"] = p->exit.load();
    return entry;
}

Json as_json(std::vector<Watched> const& all)
{
    Json list = Json::array();
    for (auto const& w : all) list.push_back(as_json(w));
    return {{"participants", list}};
}

std::string duration(double seconds)
{
    auto const s = static_cast<long>(seconds + 0.5);
    return s < 60 ? fmt::format("{} s", s) : fmt::format("{}:{:02} min", s / 60, s % 60);
}

//! A line of the table, not wider than it needs to be.
std::string line_of(Json const& p)
{
    double const windows = p["windows"].get<double>(), window = p["window"].get<double>();
    double const busy = p["compute_seconds"].get<double>(), wait = p["wait_seconds"].get<double>(),
                 exchange = p["exchange_seconds"].get<double>(), all = busy + wait + exchange;
    auto const share = [&](double part) { return all > 0 ? 100 * part / all : 0.0; };
    return fmt::format("{:<16} {:<10} {:>16} {:>5.1f} % {:>12} {:>12} {:>9.1f} {:>6.1f} {:>9.1f}  {}\n",
                       p["name"].get<std::string>(), p["phase"].get<std::string>(),
                       fmt::format("{:.0f}/{:.0f}", window, windows), windows > 0 ? 100 * window / windows : 0.0,
                       fmt::format("{:.6g} s", p["time"].get<double>()),
                       p.contains("to_go_seconds") ? duration(p["to_go_seconds"].get<double>()) : "-", share(busy),
                       share(wait), share(exchange), p.value("note", "").substr(0, 60));
}

std::string table(Json const& state)
{
    std::string text = fmt::format("{:<16} {:<10} {:>16} {:>7} {:>12} {:>12} {:>9} {:>6} {:>9}  {}\n", "participant",
                                   "phase", "window", "", "t", "to go", "compute %", "wait %", "exchange %", "note");
    for (auto const& p : state["participants"]) text += line_of(p);
    return text;
}

//! The run's exit code as the pages have it: that of whoever failed by itself.
int exit_of(std::vector<Watched> const& all)
{
    int code = 0;
    for (auto const& w : all) {
        if (w.failed() && (code == 0 || w.page->consequence == 0)) code = w.page->exit;
        if (code == 0 && w.page->phase == Phase::done && w.page->exit > 0) code = w.page->exit;  // stopped as asked
        if (code == 0 && w.gone()) code = static_cast<int>(Exit::peer_died);
    }
    return code;
}

//! Draws over what was drawn before on a terminal; below it elsewhere.
void show(Json const& state, bool json, int& drawn)
{
    if (json) {
        std::printf("%s\n", state.dump(-1, ' ', false, Json::error_handler_t::replace).c_str());
    } else {
        auto const text = table(state);
        if (drawn > 0 && ::isatty(1)) std::printf("\033[%dA\033[J", drawn);
        std::fputs(text.c_str(), stdout);
        drawn = static_cast<int>(std::count(text.begin(), text.end(), '\n'));
    }
    std::fflush(stdout);
}

}  // namespace

int watch_command(Options const& o)
{
    auto const& run = o.runs.at(0);
    auto all = pages_of(run);
    require(!all.empty(), [&] {
        return Error(run.string() +
                         ": nobody has started there (needed: the directory of a run, as given to sluice run "
                         "--out).",
                     Exit::io);
    });
    Json last;
    int drawn = 0;
    auto const between_tables = o.json || ::isatty(1) ? std::chrono::milliseconds(0) : std::chrono::seconds(5);
    auto due = Clock::now();
    for (;;) {
        for (auto& w : all) w.look();
        auto const state = as_json(all);
        bool const over = std::all_of(all.begin(), all.end(), [](Watched const& w) { return w.ended(); });
        if (state != last && (over || Clock::now() >= due)) {
            show(state, o.json, drawn);
            due = Clock::now() + between_tables;
            last = state;
        }
        if (o.once) return 0;
        if (over) return exit_of(all);
        std::this_thread::sleep_for(between_looks);
        refresh(all, run);
    }
}

}  // namespace sluice
