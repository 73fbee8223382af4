#include "participants/mpm/shared_points.hpp"

#include <utility>
#include <vector>

namespace mpm {

template <int D>
void move_points(Shares const& shares, std::span<std::uint32_t const> to, PackedPoints<D>& points)
{
    int const rank = shares.rank();
    std::size_t const begin = shares.begin(rank);
    std::vector<std::vector<double>> rows(static_cast<std::size_t>(shares.processes()));
    std::vector<std::uint32_t> here;
    for (std::size_t k = 0; k < points.size(); ++k) {
        int const owner = shares.owner(to[begin + k]);
        if (owner != rank) points.add_row(k, rows[static_cast<std::size_t>(owner)]);
        here.push_back(owner == rank ? to[begin + k] - static_cast<std::uint32_t>(begin) : PackedPoints<D>::nowhere);
    }
    points.move(here);
    std::vector<ranks::Bytes> out;
    for (auto const& some : rows) out.push_back(ranks::to_bytes(some));
    auto const in = shares.peers()->all_to_all(std::move(out));
    for (int from = 0; from < shares.processes(); ++from) {  // in the order in which they were put there
        if (from == rank) continue;
        auto const came = ranks::rows_of<double>(in[static_cast<std::size_t>(from)]);
        double const* next = came.data();
        for (std::size_t k = shares.begin(from); k < shares.end(from); ++k) {
            if (shares.owner(to[k]) != rank) continue;
            points.set_row(to[k] - begin, next);
            next += PackedPoints<D>::row;
        }
    }
}

template <int D>
void gather_points(Shares const& shares, PackedPoints<D> const& points, bool slopes, Whom whom, State<D>& state)
{
    constexpr std::size_t row = PackedPoints<D>::row;
    std::vector<double> rows;
    rows.reserve(row * points.size());
    for (std::size_t k = 0; k < points.size(); ++k) points.add_row(k, rows);
    std::vector<ranks::Bytes> out(static_cast<std::size_t>(shares.processes()));
    for (std::size_t to = 0; to < (whom == Whom::first ? 1 : out.size()); ++to) out[to] = ranks::to_bytes(rows);
    auto const in = shares.peers()->all_to_all(std::move(out));
    if (whom == Whom::first && shares.rank() > 0) return;
    for (int from = 0; from < shares.processes(); ++from) {
        auto const came = ranks::rows_of<double>(in[static_cast<std::size_t>(from)]);
        PackedPoints<D> theirs(came.size() / row);
        for (std::size_t k = 0; k < theirs.size(); ++k) theirs.set_row(k, came.data() + row * k);
        theirs.give(state, shares.begin(from), slopes);
    }
}

template <int D>
void gather_motion(Shares const& shares, PackedPoints<D> const& points, State<D>& state)
{
    using C = PackedColumns<D>;
    std::vector<double> numbers;  // index in the state, place, velocity
    numbers.reserve((1 + 2 * D) * points.size());
    for (std::size_t k = 0; k < points.size(); ++k) {
        numbers.push_back(points.order()[k]);
        for (std::size_t const column : {C::place, C::velocity})
            for (std::size_t a = 0; a < D; ++a) numbers.push_back(points[column + a][k]);
    }
    ranks::join_on_first(*shares.peers(), numbers);
    if (shares.rank() > 0) return;
    for (double const* at = numbers.data(); at < numbers.data() + numbers.size(); at += 1 + 2 * D) {
        Point<D>& p = state.points[static_cast<std::size_t>(at[0])];
        p.place = Eigen::Map<Vec<D> const>(at + 1);
        p.velocity = Eigen::Map<Vec<D> const>(at + 1 + D);
    }
}

template void move_points<2>(Shares const&, std::span<std::uint32_t const>, PackedPoints<2>&);
template void move_points<3>(Shares const&, std::span<std::uint32_t const>, PackedPoints<3>&);
template void gather_points<2>(Shares const&, PackedPoints<2> const&, bool, Whom, State<2>&);
template void gather_points<3>(Shares const&, PackedPoints<3> const&, bool, Whom, State<3>&);
template void gather_motion<2>(Shares const&, PackedPoints<2> const&, State<2>&);
template void gather_motion<3>(Shares const&, PackedPoints<3> const&, State<3>&);

}  // namespace mpm
