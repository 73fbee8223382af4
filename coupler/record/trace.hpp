#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace sluice {

enum class Activity : std::uint8_t
{
    compute,
    wait,
    exchange
};

//! Where a participant's time went, window by window, for Perfetto or chrome://tracing.
//! Memory is bounded: beyond `capacity` windows every 2nd is kept, then every 4th, ... The totals count every window.
class Trace
{
 public:
    explicit Trace(std::string participant, std::uint64_t capacity = 20'000);

    //! One interval of `window`, [begin, end) in seconds on a clock that all participants share. Windows come in order.
    void add(std::uint64_t window, Activity activity, double begin, double end);

    double seconds(Activity activity) const noexcept { return seconds_[static_cast<std::size_t>(activity)]; }
    std::uint64_t stride() const noexcept { return stride_; }  //!< every stride-th window is kept

    //! Writes the trace as JSON. Throws Error (Exit::io).
    void write(std::filesystem::path const& path) const;

 private:
    struct Interval
    {
        std::uint64_t window;
        Activity activity;
        double begin, end;  //!< [s]
    };
    std::string participant_;
    std::uint64_t capacity_;  //!< windows
    std::uint64_t stride_ = 1;
    std::array<double, 3> seconds_{};
    std::vector<Interval> intervals_;
};

//! All participants in one trace, each a process of its own; time starts at the earliest interval.
//! Throws Error (Exit::io) for a file that is no trace of ours.
void merge_traces(std::span<std::filesystem::path const> parts, std::filesystem::path const& merged);

}  // namespace sluice
