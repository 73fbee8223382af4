#include "tests/bench/measure.hpp"

#include <sched.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>

namespace bench {
namespace {

using Clock = std::chrono::steady_clock;

double microseconds_since(Clock::time_point start)
{
    return std::chrono::duration<double, std::micro>(Clock::now() - start).count();
}

double median(std::vector<double> values)
{
    auto const middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

void compute(int microseconds)
{
    auto const start = Clock::now();
    while (microseconds_since(start) < microseconds) {
    }
}

//! Median round trip [us]. Small messages are timed ten at once: a look at the clock takes as long as one of them.
double typical_round_trip(Way& way, int side, Effort::Size const& size)
{
    int const batch = size.points <= 10 && size.pause == 0 ? 10 : 1;
    for (int n = 0; n < size.rounds / 10 + 2; ++n) way.round_trip(size.points);
    std::vector<double> times;
    for (int n = 0; n < size.rounds / batch; ++n) {
        if (side == 0) compute(size.pause);
        auto const start = Clock::now();
        for (int k = 0; k < batch; ++k) way.round_trip(size.points);
        times.push_back(microseconds_since(start) / batch);
    }
    return median(times);
}

//! Keeps this thread on a core of its side's own while it lives, so that two sides that spin do not share one. Threads
//! that the ways have made stay free.
class OwnCore
{
 public:
    explicit OwnCore(int side)
    {
        ::sched_getaffinity(0, sizeof before_, &before_);
        if (CPU_COUNT(&before_) < 2) return;  // one core, or bound already
        cpu_set_t one;
        CPU_ZERO(&one);
        for (int cpu = 0, nth = 0; cpu < CPU_SETSIZE; ++cpu)
            if (CPU_ISSET(cpu, &before_) && nth++ == side) CPU_SET(cpu, &one);
        ::sched_setaffinity(0, sizeof one, &one);
    }
    OwnCore(OwnCore const&) = delete;
    OwnCore& operator=(OwnCore const&) = delete;
    ~OwnCore() { ::sched_setaffinity(0, sizeof before_, &before_); }

 private:
    cpu_set_t before_;
};

//! CPU time of this process, all threads [s].
double cpu_seconds()
{
    rusage usage = {};
    ::getrusage(RUSAGE_SELF, &usage);
    auto const seconds = [](timeval const& t) {
        return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
    };
    return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

nlohmann::json summary(Contestant const& c, Effort::Size const& size, std::vector<double> const& times,
                       std::vector<double> const& ratios)
{
    auto const metric = "round trip, " + std::to_string(size.points) + " points" + (size.pause ? ", woken" : "");
    auto const [least, most] = std::minmax_element(times.begin(), times.end());
    return {{"case", c.name},       {"metric", metric},        {"value", median(times)}, {"unit", "us"},
            {"against", c.against}, {"ratio", median(ratios)}, {"min", *least},          {"max", *most}};
}

}  // namespace

Ways make_ways(std::vector<Contestant> const& contestants, Setting const& setting)
{
    Ways ways;
    for (auto const& c : contestants) ways.push_back(c.make(setting));
    return ways;
}

nlohmann::json round_trips(std::vector<Contestant> const& contestants, Ways const& ways, int side, Effort const& effort)
{
    OwnCore const core(side);
    nlohmann::json results = nlohmann::json::array();
    for (auto const& size : effort.sizes) {
        std::vector<std::vector<double>> times(ways.size());
        for (int repetition = 0; repetition < effort.repetitions; ++repetition)
            for (std::size_t i = 0; i < ways.size(); ++i) times[i].push_back(typical_round_trip(*ways[i], side, size));
        for (std::size_t i = 0; i < ways.size(); ++i) {
            auto const raw = std::find_if(contestants.begin(), contestants.end(),
                                          [&](auto const& c) { return c.name == contestants[i].against; });
            auto const& limit = times[static_cast<std::size_t>(raw - contestants.begin())];
            std::vector<double> ratios;
            for (std::size_t r = 0; r < limit.size(); ++r) ratios.push_back(times[i][r] / limit[r]);
            results.push_back(summary(contestants[i], size, times[i], ratios));
        }
    }
    return results;
}

nlohmann::json idle_wait(Contestant const& contestant, Way& way, Effort const& effort)
{
    constexpr double allowed = 0.5;  // s of CPU a minute
    for (int n = 0; n < 100; ++n) way.round_trip(10);
    double const before = cpu_seconds();
    way.wait_in_vain(effort.idle_seconds);
    double const per_minute = (cpu_seconds() - before) / effort.idle_seconds * 60;
    nlohmann::json result = {{"case", contestant.name}, {"metric", "idle wait, CPU a minute"},
                             {"value", per_minute},     {"unit", "s"},
                             {"against", "0.5 s"},      {"ratio", per_minute / allowed}};
    return nlohmann::json::array({result});
}

}  // namespace bench
