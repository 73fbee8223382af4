// The ledger in a Session: an account for each edge, closed window by window.

#include "coupler/session.hpp"

namespace sluice {

//! One account for each edge that carries what adds up.
void Participant::Session::open_accounts()
{
    auto const open = [&](auto& channel) {
        if (Account account(channel.spec, scene.dimension, name_of(scene, channel.edge)); !account.empty())
            channel.account = std::move(account);
    };
    for (auto& channel : in) open(channel);
    for (auto& channel : out) open(channel);
    open_work();
}

//! The window stands: what came and what the solver took of it.
void Participant::Session::close_accounts()
{
    double const length = pace.scale.seconds(plan_.length);
    for (auto& channel : in) {
        close_work(channel, length);
        if (!channel.account || reads.contains(channel.number)) continue;
        channel.account->came(channel.totals(channel.guess ? *channel.guess : channel.history.front()));
        channel.account->close(length);
        check_account(*channel.account);
    }
}

void Participant::Session::check_account(Account const& account)
{
    flag(account.violation(scene.ledger_tolerance), ledger_warned_);
}

void Participant::Session::flag(std::string const& text, bool& warned)
{
    if (text.empty()) return;
    require(scene.on_violation != OnViolation::stop,
            [&] { return Error("ledger, in " + where() + ": " + text, Exit::numerical); });
    if (std::exchange(warned, true)) return;
    warnings.push_back("ledger, first in " + where() + ": " + text);
}

}  // namespace sluice
