//! A participant of whole runs that are measured: writes a cloud of points to its one partner and does nothing else.
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <string>
#include <thread>
#include <vector>

#include "coupler/coupler.hpp"

namespace {

using Clock = std::chrono::steady_clock;  // one for all processes of a machine

double seconds(Clock::duration d)
{
    return std::chrono::duration<double>(d).count();
}

//! CPU time of this process, all threads [s].
double cpu_seconds()
{
    rusage usage = {};
    ::getrusage(RUSAGE_SELF, &usage);
    auto const time = [](timeval const& t) {
        return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
    };
    return time(usage.ru_utime) + time(usage.ru_stime);
}

void sleep_for(double s)
{
    std::this_thread::sleep_for(std::chrono::duration<double>(s));
}

//! Works for this long of wall time or, on a busy machine, somewhat longer: for how long [s].
double compute(double s)
{
    auto const start = Clock::now();
    auto passed = [&] { return seconds(Clock::now() - start); };
    while (passed() < s) {
    }
    return passed();
}

//! What a tenth of the values is below: of times, without what else the machine did.
double least(std::vector<double> values)
{
    if (values.empty()) return 0;
    auto const middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 10);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

struct Config
{
    std::int64_t points = 1;
    double compute = 0;    //!< s of work in every window
    double rest = 0;       //!< s slept in every window
    double late = 0;       //!< s slept before it meets the other
    bool moving = true;    //!< positions change
    bool changing = true;  //!< values change
};

Config read_config(sluice::Reader r)
{
    Config c{.points = r.integer_or("points", 1, {.min = 1}),
             .compute = r.number_or("compute", 0.0, {.min = 0.0, .unit = "s"}),
             .rest = r.number_or("rest", 0.0, {.min = 0.0, .unit = "s"}),
             .late = r.number_or("late", 0.0, {.min = 0.0, .unit = "s"}),
             .moving = r.flag_or("moving", true),
             .changing = r.flag_or("changing", true)};
    r.finish();
    return c;
}

//! Points on a line, 1 m apart, with three numbers each; every other turn both are shifted a little, if they change.
struct Cloud
{
    explicit Cloud(Config const& c)
        : ids(static_cast<std::size_t>(c.points)),
          position{line(0), line(c.moving ? 0.25 : 0)},
          value{line(0), line(c.changing ? 0.25 : 0)}
    {
        for (std::size_t i = 0; i < ids.size(); ++i) ids[i] = static_cast<std::int64_t>(i);
    }
    std::vector<std::span<double const>> columns(std::int64_t turn) const
    {
        return {position[turn % 2], value[turn % 2]};
    }

    std::vector<std::int64_t> ids;
    std::vector<double> position[2], value[2];

 private:
    std::vector<double> line(double shift) const
    {
        std::vector<double> column(3 * ids.size(), shift);
        for (std::size_t i = 0; i < ids.size(); ++i) column[3 * i] += static_cast<double>(i);
        return column;
    }
};

void solve(sluice::Participant& self)
{
    auto const config = read_config(self.config());
    if (self.checking()) return;
    auto const partner = self.receivers("cloud").at(0);
    Cloud cloud(config);
    sleep_for(config.late);
    self.write(partner, "cloud", cloud.ids, cloud.columns(0));
    std::vector<double> besides;  // what windows took beside their computing
    double computed = 0;
    Clock::time_point first, last;
    double sum = 0;
    for (sluice::Window const& window : self.windows()) {
        auto const now = Clock::now();
        if (window.index == 0)
            first = now;
        else
            besides.push_back(seconds(now - last) - computed);
        last = now;
        for (double const x : self.read(partner, "cloud", window).columns(window.end)[1]) sum += x;
        computed = compute(config.compute);
        sleep_for(config.rest);
        self.write(partner, "cloud", cloud.ids, cloud.columns(window.index + 1));
    }
    self.fact("cpu [s]", cpu_seconds());
    self.fact("first window [s]", seconds(first.time_since_epoch()));
    self.fact("beside computing [s]", least(besides));
    self.fact("sum", sum);  // somebody may use it
}

}  // namespace

int main(int argc, char** argv)
{
    return sluice::run(argc, argv, solve);
}
