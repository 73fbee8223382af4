#include "coupler/record/trace.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <limits>
#include <nlohmann/json.hpp>
#include <string_view>

#include "coupler/base/error.hpp"
#include "coupler/record/atomic_file.hpp"

namespace sluice {
namespace {

constexpr std::array<std::string_view, 3> activity_names{"compute", "wait", "exchange"};

//! Trace Event Format: "X" is a complete event, times in microseconds, rounded to nanoseconds.
std::string event(std::string_view name, int process, double start, double duration, std::uint64_t window)
{
    return fmt::format(R"({{"ph":"X","name":"{}","pid":{},"tid":1,"ts":{:.3f},"dur":{:.3f},"args":{{"window":{}}}}})",
                       name, process, start, duration, window);
}

std::string process_name(std::string const& participant, int process)
{
    return fmt::format(R"({{"ph":"M","name":"process_name","pid":{},"tid":1,"args":{{"name":{}}}}})", process,
                       nlohmann::json(participant).dump());
}

class Events
{
 public:
    void add(std::string const& event)
    {
        if (!text_.empty()) text_ += ",\n";
        text_ += event;
    }
    void write(std::filesystem::path const& path) const
    {
        write_atomically(path, "{\"displayTimeUnit\":\"ms\",\"traceEvents\":[\n" + text_ + "\n]}\n");
    }

 private:
    std::string text_;
};

nlohmann::json read_events(std::filesystem::path const& path)
{
    auto document = nlohmann::json::parse(read_file(path), nullptr, false);
    require(document.is_object() && document.contains("traceEvents") && document["traceEvents"].is_array(), [&] {
        return Error(fmt::format("{}: not a trace (needs an object with traceEvents). Was it cut off?", path.string()),
                     Exit::io);
    });
    return std::move(document["traceEvents"]);
}

double earliest(std::vector<nlohmann::json> const& traces)
{
    double first = std::numeric_limits<double>::infinity();
    for (auto const& events : traces)
        for (auto const& e : events)
            if (e.at("ph") == "X") first = std::min(first, e.at("ts").get<double>());
    return first;
}

}  // namespace

Trace::Trace(std::string participant, std::uint64_t capacity)
    : participant_(std::move(participant)), capacity_(capacity)
{
    assert(capacity > 0);
}

void Trace::add(std::uint64_t window, Activity activity, double begin, double end)
{
    seconds_[static_cast<std::size_t>(activity)] += end - begin;
    while (window >= stride_ * capacity_) {
        stride_ *= 2;
        std::erase_if(intervals_, [&](Interval const& interval) { return interval.window % stride_ != 0; });
    }
    if (window % stride_ == 0) intervals_.push_back({window, activity, begin, end});
}

void Trace::write(std::filesystem::path const& path) const
{
    Events events;
    events.add(process_name(participant_, 1));
    for (auto const& i : intervals_)
        events.add(event(activity_names[static_cast<std::size_t>(i.activity)], 1, i.begin * 1e6,
                         (i.end - i.begin) * 1e6, i.window));
    events.write(path);
}

void merge_traces(std::span<std::filesystem::path const> parts, std::filesystem::path const& merged)
{
    std::vector<nlohmann::json> traces;
    for (auto const& part : parts) traces.push_back(read_events(part));
    Events events;
    try {
        double const zero = earliest(traces);
        for (std::size_t p = 0; p < traces.size(); ++p) {
            int const process = static_cast<int>(p) + 1;
            for (auto const& e : traces[p]) {
                if (e.at("ph") == "M")
                    events.add(process_name(e.at("args").at("name").get<std::string>(), process));
                else
                    events.add(event(e.at("name").get<std::string>(), process, e.at("ts").get<double>() - zero,
                                     e.at("dur").get<double>(), e.at("args").at("window").get<std::uint64_t>()));
            }
        }
    } catch (nlohmann::json::exception const& problem) {
        throw Error(fmt::format("{}: a trace of the wrong form ({}).", merged.string(), problem.what()), Exit::io);
    }
    events.write(merged);
}

}  // namespace sluice
