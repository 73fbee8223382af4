#include "participants/lbm/halo.hpp"

#include <cstring>

namespace lbm {
namespace {

//! Populations of one direction, that have left cells side by side along x.
struct Wanted
{
    Extent left;  //!< the first of the cells
    std::int32_t from, cells;
};

//! Room for so many populations, as a parcel counts.
std::size_t numbers_for(std::ptrdiff_t populations, Precision precision)
{
    return (static_cast<std::size_t>(populations) * bytes_of(precision) + sizeof(double) - 1) / sizeof(double);
}

}  // namespace

template <int D>
Halo<D>::Halo(Domain<D> const& domain, std::vector<Crossing> const& in, Precision precision)
    : peers_(*domain.peers()), enters_(static_cast<std::size_t>(domain.own().rows()))
{
    Layout const& own = domain.own();
    auto const run_of = [&](std::int32_t box, Extent const& cell, std::size_t direction, std::ptrdiff_t cells) {
        Run run{static_cast<std::size_t>(box), direction, cell, cells};
        for (std::size_t k = 0; k < 3; ++k) run.place[k] -= own.boxes()[run.box].first[k];
        return run;
    };
    std::vector<Border> borders(static_cast<std::size_t>(peers_.count()));
    std::vector<std::vector<Wanted>> wanted(borders.size());
    for (Crossing const& c : in) {
        auto const owner = static_cast<std::size_t>(domain.slabs().owner(c.left[D - 1]));
        Row const& row = own.row(c.row);
        borders[owner].in.push_back(run_of(row.box, {row.first + c.x, row.y, row.z}, c.into, c.cells));
        wanted[owner].push_back({c.left, c.from, c.cells});
        enters_[static_cast<std::size_t>(c.row)] = 1;
    }
    for (std::ptrdiff_t r = 0; r < own.rows(); ++r)
        if (enters(r)) rows_.push_back(r);
    std::vector<ranks::Bytes> out;
    for (auto const& some : wanted) out.push_back(ranks::to_bytes(some));
    auto const asked = peers_.all_to_all(std::move(out));
    for (std::size_t p = 0; p < borders.size(); ++p) {
        Border& border = borders[p];
        std::ptrdiff_t sent = 0, received = 0;
        for (Wanted const& w : ranks::rows_of<Wanted>(asked[p])) {
            Extent ghost = w.left;  // where they are once they have streamed
            auto const q = static_cast<std::size_t>(w.from);
            for (std::size_t k = 0; k < D; ++k) ghost[k] += Lattice<D>::c[q][k];
            border.out.push_back(run_of(own.box_of(w.left), ghost, q, w.cells));
            sent += w.cells;
        }
        for (Run const& run : border.in) received += run.cells;
        if (sent + received == 0) continue;
        parcels_.push_back({static_cast<int>(p), std::vector<double>(numbers_for(sent, precision)),
                            std::vector<double>(numbers_for(received, precision))});
        borders_.push_back(std::move(border));
    }
}

template <int D>
void Halo<D>::send(Populations<D> const& populations)
{
    populations.visit([&]<class Stored>(Rows<D, Stored> const& rows) {
        for (std::size_t b = 0; b < borders_.size(); ++b) {
            auto* to = reinterpret_cast<std::byte*>(parcels_[b].out.data());
            for (Run const& run : borders_[b].out) {
                std::size_t const bytes = static_cast<std::size_t>(run.cells) * sizeof(Stored);
                std::memcpy(to, rows.at(run.box, run.direction, run.place[1], run.place[2]) + run.place[0], bytes);
                to += bytes;
            }
        }
    });
    peers_.start(parcels_);
    under_way_ = true;
}

template <int D>
void Halo<D>::receive(Populations<D>& populations)
{
    if (!under_way_) return;
    peers_.finish();
    under_way_ = false;
    populations.visit([&]<class Stored>(Rows<D, Stored> const& rows) {
        for (std::size_t b = 0; b < borders_.size(); ++b) {
            auto const* from = reinterpret_cast<std::byte const*>(parcels_[b].in.data());
            for (Run const& run : borders_[b].in) {
                std::size_t const bytes = static_cast<std::size_t>(run.cells) * sizeof(Stored);
                std::memcpy(rows.at(run.box, run.direction, run.place[1], run.place[2]) + run.place[0], from, bytes);
                from += bytes;
            }
        }
    });
}

template class Halo<2>;
template class Halo<3>;

}  // namespace lbm
