#pragma once

#include <algorithm>
#include <cstddef>
#include <deque>
#include <span>
#include <vector>

namespace lbm {

//! Numbers one after another in memory. Runs that are the same as one of the last few are kept once: along a straight
//! surface all rows are alike, and what is short stays in the cache.
template <class Number>
class SharedRuns
{
 public:
    //! Where the run is.
    std::size_t add(std::span<Number const> run)
    {
        for (Kept const& kept : last_)
            if (kept.size == run.size() && std::equal(run.begin(), run.end(), data(kept.at))) return kept.at;
        constexpr std::size_t remembered = 8;
        last_.push_front({numbers_.size(), run.size()});
        if (last_.size() > remembered) last_.pop_back();
        numbers_.insert(numbers_.end(), run.begin(), run.end());
        return last_.front().at;
    }
    Number const* data(std::size_t at) const noexcept { return numbers_.data() + at; }
    std::size_t bytes() const noexcept { return sizeof(Number) * numbers_.size(); }

 private:
    struct Kept
    {
        std::size_t at, size;
    };
    std::deque<Kept> last_{};
    std::vector<Number> numbers_{};
};

}  // namespace lbm
