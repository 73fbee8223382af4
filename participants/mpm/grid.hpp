#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "participants/mpm/tensor.hpp"

namespace mpm {

inline constexpr std::size_t most_walls = 14;  //!< six sides and some gates

//! How a wall has acted on a node in a step.
enum class Grip : unsigned char
{
    none,
    across,  //!< no motion across
    whole    //!< no motion at all
};

template <int D>
struct Node
{
    std::array<int, D> index{};               //!< along each axis; 0: on the lower side of the domain
    double mass = 0;                          //!< [kg]
    Vec<D> momentum = Vec<D>::Zero();         //!< [N s]
    Vec<D> inner = Vec<D>::Zero();            //!< force of the stress [N]
    Vec<D> outer = Vec<D>::Zero();            //!< force of tractions and loads [N]
    Vec<D> before = Vec<D>::Zero();           //!< velocity that the points brought, turned by Coriolis [m/s]
    Vec<D> velocity = Vec<D>::Zero();         //!< after forces and walls [m/s]
    std::array<Grip, most_walls> grip{};      //!< of each wall
    Vec<D> strain_velocity = Vec<D>::Zero();  //!< of which strain is the gradient [m/s]
};

//! The nodes that points reach, in the order in which they are reached first; others do not exist. Rings of nodes lie
//! around the domain.
template <int D, class N = Node<D>>
class Grid
{
 public:
    Grid() = default;
    //! `periodic`: along which axes nodes a whole number of domains apart are one.
    explicit Grid(std::array<int, D> const& cells, std::array<bool, D> const& periodic = {}, int rings = 1)
        : rings_(rings)
    {
        std::size_t all = 1;
        for (std::size_t k = 0; k < D; ++k) {
            count_[k] = cells[k] + 1 + 2 * rings;
            period_[k] = periodic[k] ? cells[k] : 0;
            all *= static_cast<std::size_t>(count_[k]);
        }
        slot_.assign(all, none);
    }

    void clear()
    {
        for (N const& node : nodes_) slot_[place_of(node.index)] = none;
        nodes_.clear();
    }
    N& reach(std::array<int, D> index)
    {
        for (std::size_t k = 0; k < D; ++k)
            if (int const n = period_[k]; n > 0) index[k] = (index[k] % n + n) % n;
        std::int32_t& slot = slot_[place_of(index)];
        if (slot == none) {
            slot = static_cast<std::int32_t>(nodes_.size());
            nodes_.emplace_back().index = index;
        }
        return nodes_[static_cast<std::size_t>(slot)];
    }
    std::vector<N>& nodes() { return nodes_; }
    std::vector<N> const& nodes() const { return nodes_; }

 private:
    static constexpr std::int32_t none = -1;

    std::size_t place_of(std::array<int, D> const& index) const
    {
        std::size_t place = 0;
        for (std::size_t k = D; k-- > 0;)
            place = place * static_cast<std::size_t>(count_[k]) + static_cast<std::size_t>(index[k] + rings_);
        return place;
    }

    int rings_ = 1;
    std::array<int, D> count_{}, period_{};
    std::vector<std::int32_t> slot_;
    std::vector<N> nodes_;
};

}  // namespace mpm
