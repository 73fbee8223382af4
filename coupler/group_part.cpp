#include "coupler/group_part.hpp"

#include <fmt/format.h>

#include <algorithm>

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
GroupPart::GroupPart(Scene const& scene, ImplicitGroup const& group, std::vector<Member> const& members, int self,
                     std::vector<Samples::Source>& in)
    : in_(in)
{
    std::vector<int> edges;
    for (std::size_t e = 0; e < scene.edges.size(); ++e)
        if (scene.edges[e].lag == 1 && group.has(scene.edges[e].from) && group.has(scene.edges[e].to))
            edges.push_back(static_cast<int>(e));
    config_ = config_of(scene, group, edges);
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
            if (static_cast<int>(m) != self) continue;
            for (std::size_t c = 0; c < in.size(); ++c)
                if (in[c].number == e) blocks_.push_back({c, number, {config_, number, columns}});
        }
    }
    summaries_.resize(owners_.size());
}

void GroupPart::begin_window(Plan const& plan)
{
    for (auto& block : blocks_) {
        auto& channel = in_[block.channel];
        channel.begin = plan.begin;
        channel.length = plan.length;
        Frame guess = channel.history.front();
        auto const& predicted = channel.predicted();
        for (std::size_t c = 0; c < guess.columns.size(); ++c) guess.columns[c] = Held<double>::copy_of(predicted[c]);
        guess.index = plan.window + 1;
        guess.ticks = plan.begin + plan.length;
        channel.guess = std::move(guess);
    }
}

std::vector<double> GroupPart::summarize(std::uint32_t iteration, std::string const& where)
{
    std::vector<double> said;
    for (auto& block : blocks_) {
        auto& channel = in_[block.channel];
        if (iteration == 0) {
            channel.fit_guess_to_result();
            block.numerics.begin_window(channel.result->ids.values);
        }
        require(std::ranges::equal(channel.result->ids.values, channel.guess->ids.values), [&] {
            return Error(
                fmt::format("the points of {} changed between two iterations of one window, in {}: an implicit "
                            "group repeats a window with the same points.",
                            channel.spec.name, where),
                Exit::protocol);
        });
        auto& summary = summaries_[static_cast<std::size_t>(block.number)];
        summary = block.numerics.summary(columns_of(*channel.guess), columns_of(*channel.result));
        said.push_back(block.number);
        said.push_back(static_cast<double>(summary.size()));
        said.insert(said.end(), summary.begin(), summary.end());
    }
    return said;
}

bool GroupPart::hear(int member, std::vector<double> const& numbers)
{
    for (std::size_t i = 0; i + 2 <= numbers.size();) {
        double const number = numbers[i], size = numbers[i + 1];
        bool const fits = number >= 0 && number < static_cast<double>(owners_.size()) && size >= 0 &&
                          size <= static_cast<double>(numbers.size() - i - 2) &&
                          owners_[static_cast<std::size_t>(number)] == member;
        if (!fits) return false;
        auto const from = numbers.begin() + static_cast<std::ptrdiff_t>(i + 2);
        summaries_[static_cast<std::size_t>(number)].assign(from, from + static_cast<std::ptrdiff_t>(size));
        i += 2 + static_cast<std::size_t>(size);
    }
    return true;
}

Verdict GroupPart::judge() const
{
    return sluice::judge(config_, summaries_);
}

void GroupPart::improve()
{
    for (auto& block : blocks_) {
        auto& channel = in_[block.channel];
        auto next = columns_of(*channel.guess);
        block.numerics.next(summaries_, next);
        for (std::size_t c = 0; c < next.size(); ++c) channel.guess->columns[c] = Held<double>::of(std::move(next[c]));
    }
}

void GroupPart::stand()
{
    for (auto& channel : in_) {
        if (!channel.terms.inside) continue;
        channel.keep(*std::exchange(channel.edge.lag == 0 ? channel.guess : channel.result, std::nullopt));
        channel.guess.reset();
        channel.history.front().iteration = 0;
    }
    for (auto& block : blocks_) block.numerics.accept();
}

std::string GroupPart::residuals(Verdict const& verdict) const
{
    std::string text;
    for (std::size_t c = 0; c < verdict.columns.size(); ++c)
        text += fmt::format("{}{} {:.2g}", c ? ", " : "", config_.columns[c].name,
                            verdict.columns[c].residual / std::max(verdict.columns[c].result, 1e-300));
    return text;
}

void GroupPart::put(State& state) const
{
    for (auto const& block : blocks_) {
        auto const saved = block.numerics.save();
        auto const name = "block" + std::to_string(block.number);
        state.put(name + "/numbers", std::span<std::int64_t const>(saved.numbers));
        state.put(name + "/values", std::span<double const>(saved.values));
    }
}

void GroupPart::take(State const& state)
{
    for (auto& block : blocks_) {
        auto const name = "block" + std::to_string(block.number);
        auto const numbers = state.integers(name + "/numbers");
        auto const values = state.numbers(name + "/values");
        block.numerics.restore({{numbers.begin(), numbers.end()}, {values.begin(), values.end()}});
    }
}

}  // namespace sluice
