#pragma once

#include <cstdint>
#include <vector>

#include "participants/dem/state.hpp"
#include "participants/liggghts/engine.hpp"

namespace liggghts {

//! The grains that LIGGGHTS has in this process as those of our DEM, in the order of their tags.
template <int D>
class Mirror
{
 public:
    //! Lasting ids of the tags 1, 2, ...; empty: the tags are the ids.
    explicit Mirror(std::vector<std::int64_t> ids = {}) : ids_(std::move(ids)) {}

    //! Takes over where the grains are and how they move. Their external loads stay as they are here.
    void update(Rows const& rows);

    dem::Grains<D>& grains() { return grains_; }
    dem::Grains<D> const& grains() const { return grains_; }
    std::vector<int> const& tags() const { return tags_; }  //!< of the grains, ascending

 private:
    bool knows(Rows const& rows) const;
    void learn(Rows const& rows);

    std::vector<std::int64_t> ids_;
    std::vector<int> tags_;
    std::vector<std::uint32_t> index_;  //!< of a grain, by its tag
    dem::Grains<D> grains_;
};

}  // namespace liggghts
