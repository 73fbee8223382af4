#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "participants/ranks/peers.hpp"

namespace ranks {

//! What partners tell the first process, for all. `Data`: ids and columns of numbers, such as sluice::Kinematics.
template <class Data>
class KnownToAll
{
 public:
    //! `peers`: null: there is one process.
    explicit KnownToAll(Peers* peers) : peers_(peers) {}

    //! The same for all processes; valid until the next call. `told`: what this one was told.
    Data share(Data const& told)
    {
        if (!peers_) return told;
        auto const columns = told.columns();
        std::vector<double> numbers{static_cast<double>(told.id.size())};  // of ids the bits, as many of each column
        for (std::int64_t const id : told.id) numbers.push_back(std::bit_cast<double>(id));
        for (auto const& column : columns) {
            numbers.push_back(static_cast<double>(column.size()));
            numbers.insert(numbers.end(), column.begin(), column.end());
        }
        numbers_ = from_first(*peers_, numbers);
        auto const* at = numbers_.data();
        auto const next = [&] {
            auto const count = static_cast<std::size_t>(*at++);
            std::span const part{at, count};
            at += count;
            return part;
        };
        id_.clear();
        for (double const bits : next()) id_.push_back(std::bit_cast<std::int64_t>(bits));
        std::vector<std::span<double const>> all;
        for (std::size_t c = 0; c < columns.size(); ++c) all.push_back(next());
        return Data::from(id_, all);
    }

 private:
    Peers* peers_;
    std::vector<std::int64_t> id_;
    std::vector<double> numbers_;
};

}  // namespace ranks
