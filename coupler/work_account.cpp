// The books of one edge's energy: what closes, and what is said when it does not.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "coupler/work.hpp"

namespace sluice {
namespace {

constexpr std::int64_t looks_to_judge = 20;  // a load that begins with nothing is off by all of its first window
constexpr std::size_t most_halves = 8;       // one side is at most two windows ahead of the other

}  // namespace

void WorkAccount::same(std::int64_t window, char const* first, double expected, char const* second, double found,
                       double moved)
{
    double const difference = std::abs(expected - found);
    if (difference == 0 || difference <= worst_ * moved) return;
    worst_ = moved > 0 ? difference / moved : 1.0;
    worst_text_ = fmt::format("in window {} {} {:.9g} W, {} {:.9g} W", window, first, expected, second, found);
}

void WorkAccount::given(std::int64_t window, std::vector<double> power)
{
    halves_[window].given = std::move(power);
    settle(window);
}

void WorkAccount::taken(std::int64_t window, std::vector<Power> power, double length)
{
    halves_[window].taken = std::move(power);
    halves_[window].length = length;
    settle(window);
}

void WorkAccount::settle(std::int64_t window)
{
    auto const found = halves_.find(window);
    Half const half = found->second;
    if (!half.given || !half.taken) {
        if (halves_.size() > most_halves) halves_.erase(halves_.begin());  // one side never says anything
        return;
    }
    halves_.erase(halves_.begin(), std::next(found));  // an older half has lost its other one: at the begin, or resumed
    double moved = 0;
    bool known = false;
    for (std::size_t p = 0; p < half.given->size(); ++p) {
        double const given = (*half.given)[p] * half.length;
        auto const& power = (*half.taken)[p];
        if (std::isnan(given) || std::isnan(power.net)) continue;
        known = true;
        given_ += given;
        taken_ += power.net * half.length;
        moved += std::max(power.moved * half.length, std::abs(given));
    }
    looks_ += known;
    moved_ += moved;
}

std::string WorkAccount::violation(double rounding) const
{
    if (worst_ <= rounding) return {};
    return fmt::format(
        "{}: energy does not close: {}, {:.2g} of what moved (needs at most {:.2g})."
        " Loads reached other points than they were made for.",
        name_, worst_text_, worst_, rounding);
}

std::string WorkAccount::excess(double tolerance) const
{
    double const made = taken_ - given_;
    if (looks_ < looks_to_judge || std::abs(made) <= tolerance * moved_) return {};
    return fmt::format(
        "{}: staggering {} {:.3g} J in the {} windows looked at, {:.2g} of the work moved (allowed: {:.2g}). Take "
        "shorter windows, predict: linear, or an implicit group; or raise ledger.energy.tolerance.",
        name_, made > 0 ? "makes" : "takes", std::abs(made), looks_, std::abs(made) / moved_, tolerance);
}

nlohmann::ordered_json WorkAccount::summary() const
{
    return {{"windows", looks_},           {"given [J]", given_}, {"taken [J]", taken_},
            {"made [J]", taken_ - given_}, {"moved [J]", moved_}, {"closes to", worst_}};
}

}  // namespace sluice
