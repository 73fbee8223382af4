#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "participants/dem/state.hpp"
#include "participants/liggghts/engine.hpp"

namespace liggghts {

//! The grains that LIGGGHTS has in this process, in the order of their tags, as grains of our DEM: for its measures.
template <int D>
class Mirror
{
 public:
    //! As the rows are now. `ids`: lasting ones of the tags 1, 2, ...; empty: the tags are the ids.
    Mirror(std::vector<std::int64_t> const& ids, Rows const& rows);

    std::vector<int> const& tags() const { return tags_; }  //!< ascending
    dem::Grains<D> grains() const;

    //! Those of all processes, in each of them: none has a tag above `largest`, `sum` adds up numbers over the
    //! processes.
    using Sum = std::function<void(double* numbers, std::size_t count)>;
    Mirror whole(std::size_t largest, Sum const& sum) const;

 private:
    Mirror(std::vector<std::int64_t> const& ids, std::vector<int> tags);

    std::vector<std::int64_t> const* ids_;
    std::vector<int> tags_;
    std::vector<double> position_, velocity_;  //!< D numbers a grain [m, m/s]
    std::vector<double> spin_;                 //!< 1 or 3 numbers a grain [rad/s]
    std::vector<double> radius_, mass_;        //!< [m], [kg]
};

}  // namespace liggghts
