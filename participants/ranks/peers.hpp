#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>
#include <vector>

//! How the processes of one participant talk to one another. Every process makes the same calls in the same order; each
//! returns once what it brings has come.
namespace ranks {

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
    //! The same with known neighbours and sizes, once a step: sends each parcel's `out`; finish() fills its `in`. Until
    //! then neither is touched, and other calls may be made.
    virtual void start(std::span<Parcel> parcels) = 0;
    virtual void finish() = 0;
    void swap(std::span<Parcel> parcels)
    {
        start(parcels);
        finish();
    }
    //! One number of each, by rank; once a step.
    virtual std::vector<double> numbers(double mine) = 0;
};

template <class Row>
Bytes to_bytes(std::vector<Row> const& rows)
{
    static_assert(std::is_trivially_copyable_v<Row>);
    auto const bytes = std::as_bytes(std::span(rows));
    return {bytes.begin(), bytes.end()};
}

//! What to_bytes() made bytes of.
template <class Row>
std::vector<Row> rows_of(Bytes const& bytes)
{
    std::vector<Row> rows(bytes.size() / sizeof(Row));
    if (!rows.empty()) std::memcpy(rows.data(), bytes.data(), rows.size() * sizeof(Row));
    return rows;
}

//! The rows that all have, by rank.
template <class Row>
std::vector<std::vector<Row>> of_everyone(Peers& peers, std::vector<Row> const& mine)
{
    std::vector<Bytes> const out(static_cast<std::size_t>(peers.count()), to_bytes(mine));
    std::vector<std::vector<Row>> rows;
    for (Bytes const& bytes : peers.all_to_all(out)) rows.push_back(rows_of<Row>(bytes));
    return rows;
}

//! The same, one after the other.
template <class Row>
std::vector<Row> all_rows(Peers& peers, std::vector<Row> const& mine)
{
    std::vector<Row> rows;
    for (auto const& some : of_everyone(peers, mine)) rows.insert(rows.end(), some.begin(), some.end());
    return rows;
}

//! What each process has to say, by rank.
template <class Row>
std::vector<Row> everyone(Peers& peers, Row const& mine)
{
    std::vector<Row> rows;
    for (auto const& one : of_everyone(peers, std::vector{mine})) rows.push_back(one.at(0));
    return rows;
}

//! The rows of all, by rank, on process 0; elsewhere they stay as they are.
template <class Row>
void join_on_first(Peers& peers, std::vector<Row>& rows)
{
    std::vector<Bytes> out(static_cast<std::size_t>(peers.count()));
    out[0] = to_bytes(rows);
    auto const in = peers.all_to_all(std::move(out));
    if (peers.rank() != 0) return;
    rows.clear();
    for (Bytes const& bytes : in) {
        auto const some = rows_of<Row>(bytes);
        rows.insert(rows.end(), some.begin(), some.end());
    }
}

//! The rows that process 0 has, for all.
template <class Row>
std::vector<Row> from_first(Peers& peers, std::vector<Row> const& rows)
{
    std::vector<Bytes> out(static_cast<std::size_t>(peers.count()));
    bool const first = peers.rank() == 0;
    if (first) std::fill(out.begin() + 1, out.end(), to_bytes(rows));
    auto const in = peers.all_to_all(std::move(out));
    return first ? rows : rows_of<Row>(in[0]);
}

//! Bytes that process 0 has, for all, of any number: in pieces.
inline Bytes much_from_first(Peers& peers, Bytes const& bytes, std::size_t piece = std::size_t{1} << 28)
{
    std::size_t const size = from_first(peers, std::vector{bytes.size()})[0];
    Bytes all;
    all.reserve(size);
    while (all.size() < size) {
        auto const rest = std::span(bytes).subspan(std::min(all.size(), bytes.size()));
        auto const next = rest.first(std::min(piece, rest.size()));
        auto const came = from_first(peers, Bytes(next.begin(), next.end()));
        all.insert(all.end(), came.begin(), came.end());
    }
    return all;
}

//! The sums over all processes, number by number, added up by rank.
template <class Number = std::int64_t>
std::vector<Number> sums(Peers& peers, std::vector<Number> const& mine)
{
    std::vector<Bytes> const out(static_cast<std::size_t>(peers.count()), to_bytes(mine));
    std::vector<Number> sum(mine.size());
    for (Bytes const& bytes : peers.all_to_all(out)) {
        auto const one = rows_of<Number>(bytes);
        for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += one[k];
    }
    return sum;
}

}  // namespace ranks
