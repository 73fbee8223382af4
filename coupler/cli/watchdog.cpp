#include "coupler/cli/watchdog.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace sluice {
namespace {

constexpr std::size_t remembered = 101;            // windows for the median
constexpr std::chrono::milliseconds lately{1000};  // one that waits says so ten times a second

double seconds(Watchdog::Clock::duration d)
{
    return std::chrono::duration<double>(d).count();
}

double median(std::deque<double> lengths)
{
    auto const middle = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2);
    std::nth_element(lengths.begin(), middle, lengths.end());
    return *middle;
}

}  // namespace

Watchdog::Watchdog(std::vector<std::string> names, double limit)
    : names_(std::move(names)), limit_(limit), seen_(names_.size())
{}

void Watchdog::follow(Seen& seen, MappedStatus const& page, Clock::time_point now) const
{
    if (page->window != seen.window) {
        if (page->window == seen.window + 1 && seen.window >= 0) seen.lengths.push_back(seconds(now - seen.since));
        if (seen.lengths.size() > remembered) seen.lengths.pop_front();
        seen.window = page->window;
        seen.since = now;
        seen.warned = false;
    }
    if (page->wait_ns != seen.waited) {
        seen.waited = page->wait_ns;
        seen.waited_at = now;
    }
}

std::string Watchdog::who_does_what(std::vector<MappedStatus> const& pages, Clock::time_point now) const
{
    std::string busy, waiting;
    for (std::size_t m = 0; m < pages.size(); ++m) {
        if (!pages[m] || pages[m]->phase != Phase::running) continue;
        auto& list = now - seen_[m].waited_at < lately ? waiting : busy;
        list += fmt::format("{}\"{}\" in window {} of {} (t = {:.6g} s) since {:.0f} s", list.empty() ? "" : ", ",
                            names_[m], pages[m]->window.load(), pages[m]->windows.load(), pages[m]->time.load(),
                            seconds(now - seen_[m].since));
    }
    if (busy.empty()) return "everybody waits: " + waiting;
    return "computing: " + busy + (waiting.empty() ? "" : "; waiting for that: " + waiting);
}

std::optional<Watchdog::Finding> Watchdog::look(std::vector<MappedStatus> const& pages, Clock::time_point now)
{
    std::optional<std::size_t> slow;
    bool fatal = false;
    for (std::size_t m = 0; m < pages.size(); ++m) {
        auto& seen = seen_[m];
        if (!pages[m] || pages[m]->phase != Phase::running) {
            seen = {};
            continue;
        }
        follow(seen, pages[m], now);
        double const since = seconds(now - seen.since);
        bool const waits = now - seen.waited_at < lately;
        fatal = fatal || (limit_ > 0 && since > limit_);
        if (seen.lengths.empty() || waits || since < least || since < factor * median(seen.lengths)) continue;
        if (!seen.warned) slow = m;
        seen.warned = true;
    }
    if (!fatal && !slow) return std::nullopt;
    auto const what = who_does_what(pages, now);
    if (slow)  // before the end, however late this look comes
        return Finding{
            fmt::format("\"{}\" takes more than {:.0f} times as long as for its other windows ({:.2g} s). {}.",
                        names_[*slow], factor, median(seen_[*slow].lengths), what),
            false};
    return Finding{fmt::format("a window takes longer than timeouts.window = {} s: {}.", limit_, what), true};
}

}  // namespace sluice
