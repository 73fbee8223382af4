// on-death: restart. A peer died, and is started again by whoever started it; the others go back in place.
//
// A process that finds a peer dead, or is told so by the greeting of one that has already gone back, throws RollBack.
// What the solver still writes in its window is dropped; its next call of advance() forgets the session and its
// transport, meets all again as at the start, and goes on from the newest complete checkpoint. Messages of the old
// session are known by its number.

#include <unistd.h>

#include <cstdio>

#include "coupler/session.hpp"

namespace sluice {

bool Participant::Session::may_go_back() const
{
    bool const in_windows = session != 0 && schedule && !leaving_ && !said_goodbye_;
    return scene.restart_on_death && in_windows && may_reconnect_ && transport && transport->kind() != "mpi" &&
           all_can_store();
}

void Participant::Session::stop_because(Error const& why)
{
    consequence = true;
    if (may_go_back()) throw RollBack{why};
    throw why;
}

//! A peer that was started again so soon that its connection does not tell: its status page does.
void Participant::Session::look_for_newcomers()
{
    if (!may_go_back() || Clock::now() - newcomers_looked_for_ < std::chrono::milliseconds(300)) return;
    newcomers_looked_for_ = Clock::now();
    for (int m = 0; m < static_cast<int>(members.size()); ++m) {
        if (m == self) continue;
        MappedStatus const page(status_file(options.directory, name_of_member(m)), MappedStatus::Mode::open);
        int const known = greetings[static_cast<std::size_t>(m)].process;
        if (!page || page->pid == 0 || page->pid == known) continue;
        stop_because(Error("participant \"" + name_of_member(m) + "\" was started again while \"" +
                               name_of_member(self) + "\" was in " + where() + ".",
                           Exit::peer_died));
    }
}

void Participant::Session::go_back(Error const& why)
{
    book(Activity::exchange);
    std::fprintf(stderr, "%s: %s Going back to the newest checkpoint.\n", name_of_member(self).c_str(), why.what());
    forget_session();
    require(store_->newest().manifest.has_value(),
            [&] { return Error(std::string(why.what()) + " There is no checkpoint yet to go back to.", why.exit()); });
    load_newest();
    join();
    consequence = false;
    went_back = true;
    ++rollbacks_;
}

// As before connect(), but for what the solver said about itself and what it has been booked.
void Participant::Session::forget_session()
{
    status->phase = Phase::connecting;
    transport.reset();
    session = 0;
    schedule.reset();
    computing = stopped = false;
    early_.clear();
    told_.clear();
    pending_.reset();
    early_reports_.clear();
    pace.why_over.clear();
    facts.erase("ended early");
    for (std::size_t m = 0; m < greetings.size(); ++m) {
        said_bye[m] = false;
        answered_[m].reset();
        if (static_cast<int>(m) != self) greetings[m] = {};
    }
    mine().nonce = new_nonce();
    for (auto& channel : in) {
        channel.forget();
        auto const mask = reads.contains(channel.number) ? reads.at(channel.number) : ~0u;
        for (auto& origin : channel.origins)
            origin = {origin.member, FrameDecoder(channel.spec, scene.dimension, mask)};
    }
    for (auto& channel : out) {
        channel.targets.clear();
        channel.written = -1;
        channel.iteration = 0;
    }
    if (scene.on_violation != OnViolation::off) open_accounts();
    group_part_.reset();
    verdicts_.assign(members.size(), {});
    resumed_group_.reset();
}

}  // namespace sluice
