// Implicit groups: participants that repeat a window until what they exchange converges. The numbers that come back
// with lag 1 are the unknowns; each receiver holds its own, and all decide alike from small summaries.

#include <fmt/format.h>

#include "coupler/session.hpp"

namespace sluice {
namespace {

//! Every column of every lag-1 edge inside the group, in the order of the scene.
AccelerationConfig config_of(Scene const& scene, ImplicitGroup const& group, std::vector<int> const& edges)
{
    AccelerationConfig config{.method = static_cast<AccelerationConfig::Method>(group.method),
                              .relaxation = group.relaxation,
                              .history = group.history,
                              .columns = {}};
    for (int e : edges) {
        auto const& spec = scene.data[static_cast<std::size_t>(scene.edges[static_cast<std::size_t>(e)].data)];
        for (auto const& column : spec.columns) {
            auto const name = spec.name + "." + column.name;
            double tolerance = group.tolerance;
            for (auto const& key : {spec.name, name})
                if (auto const own = group.tolerances.find(key); own != group.tolerances.end()) tolerance = own->second;
            config.columns.push_back({.name = name, .tolerance = tolerance});
        }
    }
    return config;
}

AccelerationBlock::Columns columns_of(Frame const& frame)
{
    AccelerationBlock::Columns columns;
    for (auto const& column : frame.columns) columns.emplace_back(column.values.begin(), column.values.end());
    return columns;
}

}  // namespace

//! The blocks of the group: for each lag-1 edge inside, one for each process of the receiver.
void Participant::Session::open_group()
{
    if (!group) return;
    auto const inside = [&](int p) {
        return std::find(group->participants.begin(), group->participants.end(), p) != group->participants.end();
    };
    std::vector<int> edges;
    for (std::size_t e = 0; e < scene.edges.size(); ++e)
        if (scene.edges[e].lag == 1 && inside(scene.edges[e].from) && inside(scene.edges[e].to))
            edges.push_back(static_cast<int>(e));
    acceleration_ = config_of(scene, *group, edges);
    int joint = 0;
    for (int e : edges) {
        Edge const& edge = scene.edges[static_cast<std::size_t>(e)];
        auto const& spec = scene.data[static_cast<std::size_t>(edge.data)];
        std::vector<AccelerationBlock::Column> columns;
        for (auto const& column : spec.columns) columns.push_back({joint++, components(column.shape, scene.dimension)});
        for (std::size_t m = 0; m < members.size(); ++m) {
            if (members[m].participant != edge.to) continue;
            int const number = static_cast<int>(owners_.size());
            owners_.push_back(static_cast<int>(m));
            if (static_cast<int>(m) == self)
                for (std::size_t c = 0; c < in.size(); ++c)
                    if (in[c].number == e) blocks_.push_back({c, number, {acceleration_, number, columns}});
        }
    }
    if (resumed_group_) take_group_state(*std::exchange(resumed_group_, std::nullopt));
}

void Participant::Session::take_frame(Samples::Source& channel, Action const& action)
{
    auto frame = channel.take();
    if (!channel.terms.inside || action.frame == action.window) return channel.keep(std::move(frame));
    (channel.edge.lag == 0 ? channel.guess : channel.result) = std::move(frame);
}

//! Before the first iteration: the state to come back to, and what the lag-1 edges are taken to bring, as predicted.
void Participant::Session::begin_group_window()
{
    before_ = State();
    save(before_);
    for (auto& block : blocks_) {
        auto& channel = in[block.channel];
        channel.begin = plan_.begin;
        channel.length = plan_.length;
        Frame guess = channel.history.front();
        auto const& predicted = channel.predicted();
        for (std::size_t c = 0; c < guess.columns.size(); ++c) guess.columns[c] = Held<double>::copy_of(predicted[c]);
        guess.index = plan_.window + 1;
        guess.ticks = plan_.begin + plan_.length;
        channel.guess = std::move(guess);
    }
}

bool Participant::Session::agree(std::int64_t window, std::uint32_t iteration)
{
    std::vector<std::vector<double>> summaries(owners_.size());
    std::vector<double> mine_said;
    for (auto& block : blocks_) {
        auto& channel = in[block.channel];
        if (iteration == 0) {
            channel.fit_guess_to_result();
            block.numerics.begin_window(channel.result->ids.values);
        }
        require(std::ranges::equal(channel.result->ids.values, channel.guess->ids.values), [&] {
            return Error(
                fmt::format("the points of {} changed between two iterations of one window, in {}: an implicit "
                            "group repeats a window with the same points.",
                            channel.spec.name, where()),
                Exit::protocol);
        });
        auto& summary = summaries[static_cast<std::size_t>(block.number)];
        summary = block.numerics.summary(columns_of(*channel.guess), columns_of(*channel.result));
        mine_said.push_back(block.number);
        mine_said.push_back(static_cast<double>(summary.size()));
        mine_said.insert(mine_said.end(), summary.begin(), summary.end());
    }
    if (!blocks_.empty()) {
        auto const message =
            encode({.kind = MessageKind::verdict, .session = session, .frame = window, .iteration = iteration},
                   std::as_bytes(std::span(mine_said)));
        for (std::size_t m = 0; m < members.size(); ++m)
            if (static_cast<int>(m) != self && in_group(static_cast<int>(m)))
                send(static_cast<int>(m), message, Clock::time_point::max());
    }
    gather_summaries(window, iteration, summaries);
    auto const verdict = judge(acceleration_, summaries);
    bool const enough = static_cast<int>(iteration) + 1 >= group->max_iterations;
    ++iterations_;
    if (verdict.converged || enough) {
        if (!verdict.converged && unconverged_++ == 0) {
            std::string rest;
            for (std::size_t c = 0; c < verdict.columns.size(); ++c)
                rest += fmt::format("{}{} {:.2g}", c ? ", " : "", acceleration_.columns[c].name,
                                    verdict.columns[c].residual / std::max(verdict.columns[c].result, 1e-300));
            warnings.push_back(
                fmt::format("window {} did not converge in {} iterations (relative residuals: {}). Raise "
                            "max_iterations, or take shorter windows.",
                            window, iteration + 1, rest));
        }
        stand();
        schedule->agreed(true);
        return true;
    }
    for (auto& block : blocks_) {
        auto& channel = in[block.channel];
        auto next = columns_of(*channel.guess);
        block.numerics.next(summaries, next);
        for (std::size_t c = 0; c < next.size(); ++c) channel.guess->columns[c] = Held<double>::of(std::move(next[c]));
    }
    for (auto& channel : in)
        if (channel.account) channel.account->forget_samples();
    restore(before_);
    schedule->agreed(false);
    return false;
}

//! The window stands: the last iteration's frames become history.
void Participant::Session::stand()
{
    close_accounts();
    for (auto& channel : in) {
        if (!channel.terms.inside) continue;
        channel.keep(*std::exchange(channel.edge.lag == 0 ? channel.guess : channel.result, std::nullopt));
        channel.guess.reset();
        channel.history.front().iteration = 0;
    }
    for (auto& block : blocks_) block.numerics.accept();
    begin_ = plan_.begin + plan_.length;
    status->window = plan_.window + 1;
}

bool Participant::Session::in_group(int member) const
{
    auto const& all = group->participants;
    return std::find(all.begin(), all.end(), members[static_cast<std::size_t>(member)].participant) != all.end();
}

//! Waits for the summaries of all blocks that other processes own.
void Participant::Session::gather_summaries(std::int64_t window, std::uint32_t iteration,
                                            std::vector<std::vector<double>>& summaries)
{
    std::vector<char> heard(members.size());
    for (int const owner : owners_) {
        auto const at = static_cast<std::size_t>(owner);
        if (owner == self || heard[at]) continue;
        heard[at] = true;
        auto& queue = verdicts_[at];
        if (queue.empty()) wait_for(owner, [&] { return !queue.empty(); });
        auto const said = std::move(queue.front());
        queue.pop_front();
        auto const refuse = [&] {
            return Error("a verdict of \"" + name_of_member(owner) + "\" in " + where() + " that does not fit.",
                         Exit::protocol);
        };
        require(said.window == window && said.iteration == iteration, refuse);
        for (std::size_t i = 0; i + 2 <= said.numbers.size();) {
            double const number = said.numbers[i], size = said.numbers[i + 1];
            require(number >= 0 && number < static_cast<double>(owners_.size()) && size >= 0 &&
                        size <= static_cast<double>(said.numbers.size() - i - 2) &&
                        owners_[static_cast<std::size_t>(number)] == owner,
                    refuse);
            auto const from = said.numbers.begin() + static_cast<std::ptrdiff_t>(i + 2);
            summaries[static_cast<std::size_t>(number)].assign(from, from + static_cast<std::ptrdiff_t>(size));
            i += 2 + static_cast<std::size_t>(size);
        }
    }
}

void Participant::Session::take_verdict(int member, Header const& header, std::vector<double> numbers)
{
    require(group && in_group(member), [&] {
        return Error("a verdict of \"" + name_of_member(member) + "\", which is in no group with this one.",
                     Exit::protocol);
    });
    verdicts_[static_cast<std::size_t>(member)].push_back({header.frame, header.iteration, std::move(numbers)});
}

void Participant::Session::put_group_state(State& state) const
{
    for (auto const& block : blocks_) {
        auto const saved = block.numerics.save();
        auto const name = "block" + std::to_string(block.number);
        state.put(name + "/numbers", std::span<std::int64_t const>(saved.numbers));
        state.put(name + "/values", std::span<double const>(saved.values));
    }
}

void Participant::Session::take_group_state(State const& state)
{
    for (auto& block : blocks_) {
        auto const name = "block" + std::to_string(block.number);
        auto const numbers = state.integers(name + "/numbers");
        auto const values = state.numbers(name + "/values");
        block.numerics.restore({{numbers.begin(), numbers.end()}, {values.begin(), values.end()}});
    }
}

}  // namespace sluice
