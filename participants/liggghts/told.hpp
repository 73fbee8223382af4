#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "participants/liggghts/engine.hpp"

namespace liggghts {

//! What partners are told of the grains that LIGGGHTS has in this process, in the order of its rows: nothing is sorted,
//! and in space nothing is copied.
template <int D>
class Told
{
 public:
    //! `ids`: lasting ones of the tags 1, 2, ...; empty: the tags are the ids. They outlive this.
    explicit Told(std::vector<std::int64_t> const& ids) : ids_(&ids) {}

    void update(Rows const& rows);

    std::vector<int> const& tags() const { return tags_; }
    std::vector<std::int64_t> const& id() const { return id_; }
    //! Of the rows of the last update(), valid until LIGGGHTS goes on: D numbers a grain [m, m/s], 1 or 3 [rad/s], 1
    //! [m].
    std::span<double const> position() const
    {
        return D == 2 ? std::span<double const>(position_) : column(rows_.place);
    }
    std::span<double const> velocity() const
    {
        return D == 2 ? std::span<double const>(velocity_) : column(rows_.velocity);
    }
    std::span<double const> spin() const { return D == 2 ? std::span<double const>(spin_) : column(rows_.spin); }
    std::span<double const> radius() const { return {rows_.radius, tags_.size()}; }

 private:
    std::span<double const> column(double* const* rows) const  // LIGGGHTS has them one behind the other
    {
        return tags_.empty() ? std::span<double const>() : std::span<double const>(rows[0], 3 * tags_.size());
    }

    std::vector<std::int64_t> const* ids_;
    Rows rows_;
    std::vector<int> tags_;
    std::vector<std::int64_t> id_;
    std::vector<double> position_, velocity_, spin_;  //!< in the plane, where rows have three numbers
};

}  // namespace liggghts
