#include "coupler/cli/progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace sluice {
namespace {

using Clock = std::chrono::steady_clock;
constexpr int bar_width = 24;

std::string duration(double seconds)
{
    auto const s = static_cast<long>(seconds + 0.5);
    return s < 60 ? fmt::format("{} s", s) : fmt::format("{}:{:02} min", s / 60, s % 60);
}

}  // namespace

Progress::Progress(std::vector<std::string> names, bool quiet)
    : names_(std::move(names)), quiet_(quiet), terminal_(::isatty(2) != 0)
{}

std::string Progress::line(std::vector<MappedStatus> const& pages)
{
    std::int64_t window = -1, windows = 0;
    double time = 0;
    for (std::size_t p = 0; p < pages.size(); ++p) {
        if (!pages[p]) return "starting";
        Phase const phase = pages[p]->phase;
        std::string const note(pages[p]->note, strnlen(pages[p]->note, sizeof pages[p]->note));
        if (phase == Phase::preparing) return names_[p] + ": " + (note.empty() ? "preparing" : note);
        if (phase == Phase::connecting) return names_[p] + ": waiting for the others";
        if (window < 0 || pages[p]->window < window) {
            window = pages[p]->window;
            windows = pages[p]->windows;
            time = pages[p]->time;
        }
    }
    if (windows <= 0) return "starting";
    if (!running_) {
        running_ = true;
        first_window_ = Clock::now();
    }
    double const share = static_cast<double>(window) / static_cast<double>(windows);
    double const elapsed = std::chrono::duration<double>(Clock::now() - first_window_).count();
    auto const filled = static_cast<int>(share * bar_width);
    std::string text = fmt::format("[{:#<{}}{:.<{}}] {:3.0f} %  t = {:.4g} s  window {}/{}", "", filled, "",
                                   bar_width - filled, share * 100, time, window, windows);
    if (window > 0 && elapsed > 1) text += "  to go " + duration(elapsed * (1 - share) / share);
    for (std::size_t p = 0; p < pages.size(); ++p) {
        double const busy = static_cast<double>(pages[p]->compute_ns);
        double const all = busy + static_cast<double>(pages[p]->wait_ns) + static_cast<double>(pages[p]->exchange_ns);
        if (all > 0) text += fmt::format("  {} {:.0f} % busy", names_[p], 100 * busy / all);
    }
    return text;
}

void Progress::show(std::vector<MappedStatus> const& pages)
{
    if (quiet_ || Clock::now() < next_) return;
    next_ = Clock::now() + (terminal_ ? std::chrono::milliseconds(200) : std::chrono::milliseconds(5000));
    auto const text = line(pages);
    std::fprintf(stderr, terminal_ ? "\r\033[K%s" : "%s\n", text.c_str());
    std::fflush(stderr);
    drawn_ = terminal_;
}

void Progress::clear()
{
    if (drawn_) std::fprintf(stderr, "\r\033[K");
    drawn_ = false;
}

}  // namespace sluice
