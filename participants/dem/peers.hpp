#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>
#include <vector>

//! How the processes that share the grains of one run talk to one another. Every process makes the same calls in the
//! same order; each returns once what it brings has come.
namespace dem {

using Bytes = std::vector<std::byte>;

//! Numbers to and from one other process; both know how many.
struct Parcel
{
    int peer = 0;
    std::vector<double> out, in;
};

class Peers
{
 public:
    virtual ~Peers() = default;

    virtual int rank() const = 0;  //!< which process this is, from 0
    virtual int count() const = 0;

    //! Gives each process its bytes; returns what came, by sender. Whoever waits long hardly computes meanwhile.
    virtual std::vector<Bytes> all_to_all(std::vector<Bytes> out) = 0;
    //! The same with known neighbours and sizes, once a step: fills each parcel's `in`.
    virtual void swap(std::span<Parcel> parcels) = 0;
    //! The largest of the numbers of all; once a step.
    virtual int largest(int mine) = 0;
};

//! What each process has to say, by rank.
template <class Row>
std::vector<Row> everyone(Peers& peers, Row const& mine)
{
    static_assert(std::is_trivially_copyable_v<Row>);
    auto const* const from = reinterpret_cast<std::byte const*>(&mine);
    std::vector<Bytes> const out(static_cast<std::size_t>(peers.count()), Bytes(from, from + sizeof mine));
    std::vector<Row> rows;
    for (Bytes const& bytes : peers.all_to_all(out)) std::memcpy(&rows.emplace_back(), bytes.data(), sizeof(Row));
    return rows;
}

//! The sums over all processes, number by number.
inline std::vector<std::int64_t> sums(Peers& peers, std::vector<std::int64_t> const& mine)
{
    auto const* const from = reinterpret_cast<std::byte const*>(mine.data());
    std::size_t const size = mine.size() * sizeof mine[0];
    std::vector<Bytes> const out(static_cast<std::size_t>(peers.count()), Bytes(from, from + size));
    std::vector<std::int64_t> sum(mine.size()), one(mine.size());
    for (Bytes const& bytes : peers.all_to_all(out)) {
        if (size > 0) std::memcpy(one.data(), bytes.data(), size);
        for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += one[k];
    }
    return sum;
}

}  // namespace dem
