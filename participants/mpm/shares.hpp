#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

#include "coupler/base/error.hpp"
#include "participants/ranks/peers.hpp"

namespace mpm {

//! Which process has which points, by their places in the one order of all: each a run of chunks, the last of which may
//! not be full. One process has all.
class Shares
{
 public:
    static constexpr std::size_t chunk = 1024;  //!< points

    Shares() = default;
    //! `peers`: null: there is one process.
    Shares(ranks::Peers* peers, std::size_t points) : peers_(peers), points_(points)
    {
        std::size_t const chunks = (points + chunk - 1) / chunk, count = static_cast<std::size_t>(processes());
        cut_.clear();
        for (std::size_t r = 0; r <= count; ++r) cut_.push_back(r * chunks / count);
    }

    ranks::Peers* peers() const { return peers_; }
    int rank() const { return peers_ ? peers_->rank() : 0; }
    int processes() const { return peers_ ? peers_->count() : 1; }
    std::size_t points() const { return points_; }
    std::size_t first_chunk(int rank) const { return cut_[static_cast<std::size_t>(rank)]; }
    std::size_t begin(int rank) const { return std::min(points_, first_chunk(rank) * chunk); }
    std::size_t end(int rank) const { return begin(rank + 1); }
    int owner(std::size_t place) const
    {
        return static_cast<int>(std::upper_bound(cut_.begin(), cut_.end(), place / chunk) - cut_.begin()) - 1;
    }

 private:
    ranks::Peers* peers_ = nullptr;
    std::size_t points_ = 0;
    std::vector<std::size_t> cut_{0, 0};  //!< the first chunk of each, and the number of chunks
};

//! Throws sluice::Error (config) if there are fewer chunks than processes.
inline void require_chunks(std::size_t points, int processes)
{
    std::size_t const chunks = (points + Shares::chunk - 1) / Shares::chunk;
    sluice::require(static_cast<std::size_t>(processes) <= chunks, [&] {
        return sluice::Error("mpm: " + std::to_string(processes) + " processes for " + std::to_string(points) +
                             " points (needed: " + std::to_string(Shares::chunk) +
                             " or more for each, but the last). Give fewer ranks.");
    });
}

}  // namespace mpm
