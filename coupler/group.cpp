// Implicit groups in a Session: participants that repeat a window until what they exchange converges.

#include <fmt/format.h>

#include "coupler/session.hpp"

namespace sluice {

void Participant::Session::open_group()
{
    if (!group) return;
    group_part_.emplace(scene, *group, members, self, in);
    if (resumed_group_) group_part_->take(*std::exchange(resumed_group_, std::nullopt));
}

void Participant::Session::take_frame(Samples::Source& channel, Action const& action)
{
    auto frame = channel.take();
    if (!channel.terms.inside || action.frame == action.window) return channel.keep(std::move(frame));
    (channel.edge.lag == 0 ? channel.guess : channel.result) = std::move(frame);
}

//! Before the first iteration: the state to come back to.
void Participant::Session::begin_group_window()
{
    before_ = State();
    save(before_);
    group_part_->begin_window(plan_);
}

bool Participant::Session::agree(std::int64_t window, std::uint32_t iteration)
{
    auto const said = group_part_->summarize(iteration, where());
    if (group_part_->has_unknowns()) {
        auto const message =
            encode({.kind = MessageKind::verdict, .session = session, .frame = window, .iteration = iteration},
                   std::as_bytes(std::span(said)));
        for (std::size_t m = 0; m < members.size(); ++m)
            if (static_cast<int>(m) != self && group->has(members[m].participant))
                send(static_cast<int>(m), message, Clock::time_point::max());
    }
    hear_group(window, iteration);
    auto const verdict = group_part_->judge();
    bool const enough = static_cast<int>(iteration) + 1 >= group->max_iterations;
    ++iterations_;
    if (verdict.converged || enough) {
        if (!verdict.converged && unconverged_++ == 0)
            warnings.push_back(
                fmt::format("window {} did not converge in {} iterations (relative residuals: {}). Raise "
                            "max_iterations, or take shorter windows.",
                            window, iteration + 1, group_part_->residuals(verdict)));
        close_accounts();
        group_part_->stand();
        begin_ = plan_.begin + plan_.length;
        status->window = plan_.window + 1;
        schedule->agreed(true);
        return true;
    }
    group_part_->improve();
    for (auto& channel : in)
        if (channel.account) channel.account->forget_samples();
    restore(before_);
    schedule->agreed(false);
    return false;
}

//! Waits for the summaries of all blocks that other processes own.
void Participant::Session::hear_group(std::int64_t window, std::uint32_t iteration)
{
    std::vector<char> heard(members.size());
    for (int const owner : group_part_->owners()) {
        auto const at = static_cast<std::size_t>(owner);
        if (owner == self || heard[at]) continue;
        heard[at] = true;
        auto& queue = verdicts_[at];
        if (queue.empty()) wait_for(owner, [&] { return !queue.empty(); });
        auto const said = std::move(queue.front());
        queue.pop_front();
        bool const fits =
            said.window == window && said.iteration == iteration && group_part_->hear(owner, said.numbers);
        require(fits, [&] {
            return Error("a verdict of \"" + name_of_member(owner) + "\" in " + where() + " that does not fit.",
                         Exit::protocol);
        });
    }
}

void Participant::Session::take_verdict(int member, Header const& header, std::vector<double> numbers)
{
    require(group && group->has(members[static_cast<std::size_t>(member)].participant), [&] {
        return Error("a verdict of \"" + name_of_member(member) + "\", which is in no group with this one.",
                     Exit::protocol);
    });
    verdicts_[static_cast<std::size_t>(member)].push_back({header.frame, header.iteration, std::move(numbers)});
}

}  // namespace sluice
