#include <fmt/format.h>
#include <signal.h>

#include <cmath>
#include <cstdio>
#include <sstream>

#include "coupler/session.hpp"

namespace sluice {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

//! The first line in which two canonical scenes differ, as both sides have it.
std::string difference(std::string const& here, std::string const& there)
{
    std::istringstream a(here), b(there);
    for (std::string x, y;;) {
        bool const more_a = static_cast<bool>(std::getline(a, x)), more_b = static_cast<bool>(std::getline(b, y));
        if (!more_a && !more_b) return "nothing that this version compares";
        if (x != y || more_a != more_b)
            return "\"" + (more_a ? x : "nothing") + "\" here, \"" + (more_b ? y : "nothing") + "\" there";
    }
}

bool divides(double step, double window)
{
    double const ratio = window / step;
    return ratio > 0.5 && std::abs(ratio - std::round(ratio)) < 1e-6 * ratio;
}

}  // namespace

double choose_window(Scene const& scene, std::vector<Greeting> const& greetings)
{
    double exact = 0, bound = 0;
    for (Greeting const& g : greetings) {
        if (g.window <= 0) continue;
        if (g.exact)
            exact = std::max(exact, g.window);
        else
            bound = bound == 0 ? g.window : std::min(bound, g.window);
    }
    double const window = scene.window.value_or(exact > 0 ? exact : std::min(bound, scene.end));
    require(window > 0, [&] {
        return Error(scene.file.string() +
                     ": time.window is auto, but no participant proposes a length. Give it in s.");
    });
    for (std::size_t p = 0; p < greetings.size(); ++p)
        require(!greetings[p].exact || divides(greetings[p].window, window), [&] {
            return Error(fmt::format("{}: time.window = {} s is not a multiple of the step of \"{}\" ({} s). Use auto.",
                                     scene.file.string(), window, scene.participants[p].name, greetings[p].window));
        });
    return window;
}

std::string Participant::Session::command_of(int participant) const
{
    auto const& spec = scene.participants[static_cast<std::size_t>(participant)];
    std::string text = spec.solver;
    for (auto const& word : spec.command) text += (text.empty() ? "" : " ") + word;
    text += " " + scene.file.string() + " --as " + spec.name + " --out " + options.directory.string();
    for (auto const& change : options.overrides) text += " --set " + change;
    return text;
}

bool Participant::Session::greet(int peer)
{
    auto const& mine = greetings[static_cast<std::size_t>(self)];
    nlohmann::json const hello = {{"name", options.name}, {"nonce", mine.nonce}, {"window", mine.window},
                                  {"exact", mine.exact},  {"scene", scene.hash}, {"canonical", scene.canonical}};
    auto const bytes =
        encode_text(MessageKind::hello, 0, 0, hello.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
    return transport->try_send(peer, bytes);
}

//! Whether a peer's process on this host is alive and busy before its first window, e.g. settling a packing.
bool Participant::Session::is_preparing(int peer) const
{
    auto const& name = scene.participants[static_cast<std::size_t>(peer)].name;
    MappedStatus const page(status_file(options.directory, name), MappedStatus::Mode::open);
    return page && page->phase == Phase::preparing && page->pid > 0 && ::kill(page->pid, 0) == 0;
}

void Participant::Session::meet_all()
{
    std::vector<char> greeted(greetings.size());
    greeted[static_cast<std::size_t>(self)] = greetings[static_cast<std::size_t>(self)].arrived = true;
    auto start = Clock::now();
    auto next_word = start + seconds(5);
    for (;;) {
        std::string missing, commands;
        for (int p = 0; p < static_cast<int>(greetings.size()); ++p) {
            auto const at = static_cast<std::size_t>(p);
            if (p != self && transport->lost(p))
                greeted[at] = greetings[at].arrived = false;  // it may be started again
            if (!greeted[at]) greeted[at] = greet(p);
            if (greeted[at] && greetings[at].arrived) continue;
            missing += (missing.empty() ? "\"" : ", \"") + scene.participants[at].name + "\"";
            commands += "\n    " + command_of(p);
            if (p != self && is_preparing(p)) start = Clock::now();
        }
        if (missing.empty()) return;
        auto const now = Clock::now();
        require(now - start < in_milliseconds(scene.connect_timeout), [&] {
            return Error(fmt::format("participant \"{}\": {} did not come within {} s. Start with:{}", options.name,
                                     missing, scene.connect_timeout, commands),
                         Exit::timeout);
        });
        if (now > next_word) {
            std::fprintf(stderr, "%s: waiting for %s; start with:%s\n", options.name.c_str(), missing.c_str(),
                         commands.c_str());
            next_word += seconds(5);
        }
        if (auto incoming = transport->receive(milliseconds(5))) handle(*incoming);
    }
}

void Participant::Session::handle_greeting(int peer, std::string const& text)
{
    auto const& peer_name = scene.participants[static_cast<std::size_t>(peer)].name;
    auto const hello = nlohmann::json::parse(text, nullptr, false);
    require(hello.is_object() && hello.value("name", "") == peer_name, [&] {
        return Error("greeting from \"" + peer_name + "\" cannot be read. Do all participants run the same Sluice?",
                     Exit::protocol);
    });
    auto const canonical = hello.value("canonical", "");
    require(hello.value("scene", std::uint64_t{0}) == scene.hash && canonical == scene.canonical, [&] {
        return Error("participants \"" + options.name + "\" and \"" + peer_name + "\" have different scenes: " +
                         difference(scene.canonical, canonical) + ". Give both the same file and the same --set.",
                     Exit::protocol);
    });
    if (greetings[static_cast<std::size_t>(peer)].arrived) greet(peer);  // it was started again: it does not know us
    greetings[static_cast<std::size_t>(peer)] = {true, hello.value("nonce", std::uint64_t{0}),
                                                 hello.value("window", 0.0), hello.value("exact", false)};
}

}  // namespace sluice
