#pragma once

#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "participants/dem/state.hpp"

//! What partners do to the grains, by lasting id, as loads on the grains of the run.
namespace dem {

//! Where a grain of a lasting id is in arrays: a table for ids that lie close together, else a map.
class Finder
{
 public:
    explicit Finder(std::vector<std::int64_t> const& id);
    //! Throws sluice::Error (protocol) if none has it.
    std::size_t operator()(std::int64_t id) const;

 private:
    std::size_t look_up(std::int64_t id) const;

    std::size_t count_;
    std::int64_t lowest_ = 0;
    std::vector<std::size_t> table_;  //!< by id - lowest; count: none has this id
    std::unordered_map<std::int64_t, std::size_t> index_;
};

//! What one partner does to some grains at one time.
struct PartnerLoad
{
    std::span<std::int64_t const> id;
    std::span<double const> force;   //!< 2 or 3 numbers a grain [N]
    std::span<double const> torque;  //!< 1 or 3 numbers a grain [N m]; empty: none
};

//! The sum over partners for each grain of the run.
template <int D>
class PartnerLoads
{
 public:
    //! `id`: of all grains of the run, in their order.
    explicit PartnerLoads(std::vector<std::int64_t> const& id) : find_(id), sum_(id.size()) {}

    //! Takes what the partners do now. Throws as Finder.
    void take(std::vector<PartnerLoad> const& parts);
    std::vector<Load<D>> const& on_grains() const { return sum_; }
    Vec<D> force() const { return force_; }  //!< on all of them [N]

 private:
    void add(PartnerLoad const& part);

    Finder find_;
    std::vector<Load<D>> sum_;
    Vec<D> force_{};
};

}  // namespace dem
