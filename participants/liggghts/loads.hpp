#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "participants/liggghts/engine.hpp"

namespace liggghts {

//! What acts on grains from outside, in any order of the grains: three numbers of force [N] and three of torque [N m] a
//! grain, in the plane as well (there per metre). Where that is the order of LIGGGHTS' rows nothing is looked up.
class Loads
{
 public:
    //! Zero, on these grains in this order.
    void reset(std::span<int const> tags);
    void set(std::span<int const> tags, std::span<double const> forces, std::span<double const> torques);
    //! To the mean of two, which have the same grains in the same order.
    void set_mean(Loads const& a, Loads const& b);

    std::vector<int> const& tags() const { return tags_; }
    //! Where the load of each tag stands; beyond the end, `nobody`: it has none.
    std::vector<std::uint32_t> by_tag() const;

    std::vector<double> force, torque;

    //! To what acts on the rows.
    void add_to(Rows const& rows);
    //! Takes `before` out of what acts on the rows and adds this; what `before` holds afterwards is of no use.
    void replace(Rows const& rows, Loads& before);
    //! What they do, as the rows move [W].
    double power(Rows const& rows);

    static constexpr std::uint32_t nobody = ~0u;

 private:
    void set_tags(std::span<int const> tags);
    bool fits(Rows const& rows) const;
    //! Calls `each(row, grain)`, numbers of rows and of loads, for all rows that have a load.
    template <class Each>
    void each_row(Rows const& rows, Each&& each);

    std::vector<int> tags_;
    std::vector<int> rows_;             //!< tags of the rows to which where_ belongs
    std::vector<std::uint32_t> where_;  //!< the load of each row, or nobody
};

}  // namespace liggghts
