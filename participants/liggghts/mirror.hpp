#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "participants/dem/state.hpp"
#include "participants/liggghts/engine.hpp"

namespace liggghts {

//! The grains that LIGGGHTS has in this process, in the order of their tags: as columns, for every window, and as
//! grains of our DEM, for its measures.
template <int D>
class Mirror
{
 public:
    //! Lasting ids of the tags 1, 2, ...; empty: the tags are the ids.
    explicit Mirror(std::vector<std::int64_t> ids = {}) : ids_(std::move(ids)) {}

    //! Takes over where the grains are and how they move.
    void update(Rows const& rows);

    std::vector<int> const& tags() const { return tags_; }  //!< ascending
    std::vector<std::int64_t> const& id() const { return id_; }
    std::vector<double> const& position() const { return position_; }  //!< D numbers a grain [m]
    std::vector<double> const& velocity() const { return velocity_; }  //!< [m/s]
    std::vector<double> const& spin() const { return spin_; }          //!< 1 or 3 numbers a grain [rad/s]
    std::vector<double> const& radius() const { return radius_; }      //!< [m]

    dem::Grains<D> grains() const;

    //! Those of all processes, in each of them: none has a tag above `largest`, `sum` adds up numbers over the
    //! processes.
    using Sum = std::function<void(double* numbers, std::size_t count)>;
    Mirror whole(std::size_t largest, Sum const& sum) const;
    std::int64_t largest_tag() const { return tags_.empty() ? 0 : tags_.back(); }

 private:
    bool knows(Rows const& rows) const;
    void learn(std::vector<int> tags);

    std::vector<std::int64_t> ids_;
    std::vector<int> tags_;
    std::vector<std::uint32_t> index_;  //!< of a grain, by its tag
    std::vector<std::int64_t> id_;
    std::vector<double> position_, velocity_, spin_, radius_, mass_;
};

}  // namespace liggghts
