// What a Session leaves in the run's own folder, RUN/.sluice: its configuration, its summary, its trace.

#include <fmt/format.h>

#include <fstream>

#include "coupler/record/atomic_file.hpp"
#include "coupler/session.hpp"

namespace sluice {

//! Leaves the scene as this process reads it, defaults filled in. A run that goes on says where its solver's own block
//! is not what it was: checkpoints do not tell, since some keys (threads) change no bit.
void Participant::Session::keep_config()
{
    auto const own = "participants." + options.name + ".config.";
    std::string all, now, then;
    for (auto const& [path, value] : loaded.diagnostics->effective) {
        all += path + " = " + value + "\n";
        if (path.starts_with(own)) now += path + " = " + value + "\n";
    }
    auto const file = options.directory / ".sluice" / (name_of_member(self) + ".config");
    if (std::ifstream before(file); options.resume && before)
        for (std::string line; std::getline(before, line);)
            if (line.starts_with(own)) then += line + "\n";
    if (!then.empty() && then != now)
        warnings.push_back("its config is not that of its checkpoint: " + difference(now, then) +
                           ". The run goes on, but not as it would have.");
    std::ofstream(file) << all;
}

void Participant::Session::write_summary(int exit) const
{
    if (options.given) return;
    auto const in_seconds = [](std::int64_t ns) { return static_cast<double>(ns) * 1e-9; };
    auto const& spec = scene.participants[static_cast<std::size_t>(participant)];
    double const wall = std::chrono::duration<double>(Clock::now() - start_).count();
    auto said = warnings;
    nlohmann::ordered_json waits = nlohmann::ordered_json::object();
    std::size_t slowest = 0;
    for (std::size_t p = 0; p < waited_.size(); ++p) {
        if (waited_[p] > 0) waits[scene.participants[p].name] = in_seconds(waited_[p]);
        if (waited_[p] > waited_[slowest]) slowest = p;
    }
    double const waited = in_seconds(status->wait_ns);
    double const busy = waited + in_seconds(status->compute_ns) + in_seconds(status->exchange_ns);
    if (exit == 0 && busy > 1 && waited > busy / 2)
        said.push_back(
            fmt::format("waited {:.0f} % of the time, mostly for \"{}\" ({:.1f} s of {:.1f} s): that one is "
                        "the slow partner.",
                        100 * waited / busy, scene.participants[slowest].name, in_seconds(waited_[slowest]), waited));
    nlohmann::ordered_json summary = {{"name", name_of_member(self)},
                                      {"solver", spec.solver.empty() ? spec.command.at(0) : spec.solver},
                                      {"exit", exit},
                                      {"windows", status->window.load()},
                                      {"window_seconds", window_length},
                                      {"end_time", pace.scale.seconds(begin_)},
                                      {"compute_seconds", in_seconds(status->compute_ns)},
                                      {"wait_seconds", waited},
                                      {"exchange_seconds", in_seconds(status->exchange_ns)},
                                      {"wall_seconds", wall},
                                      {"waits_for", waits},
                                      {"transport", transport ? transport->kind() : "none"},
                                      {"bytes_sent", bytes_sent},
                                      {"facts", facts},
                                      {"warnings", said},
                                      {"skipped", skipped}};
    if (group) summary["iterations"] = iterations_;
    for (auto const& channel : out)
        if (channel.account) summary["ledger"].push_back(channel.account->summary());
    for (auto const& channel : in) {
        if (!channel.account) continue;
        summary["ledger"].push_back(channel.account->summary());
        if (channel.work) summary["ledger"].back()["energy"] = channel.work->account->summary();
    }
    if (resumed_at > 0) summary["resumed_at"] = resumed_at;
    if (rollbacks_ > 0) summary["rollbacks"] = rollbacks_;
    auto const base = options.directory / ".sluice" / name_of_member(self);
    write_atomically(base.string() + ".json", summary.dump(1, ' ', false, nlohmann::json::error_handler_t::replace));
    if (trace) trace->write(base.string() + ".trace.json");
}

}  // namespace sluice
