#include "participants/lbm/walls.hpp"

#include <algorithm>
#include <map>
#include <numbers>
#include <optional>

namespace lbm {
namespace {

//! Over the largest velocity of a side's inflow, where the link of direction c into a cell crosses the side.
double profile(Boundary const& side, std::array<int, 3> const& c, Extent const& cell)
{
    double product = 1;
    for (std::size_t k = 0; k < 3; ++k)
        if (!side.profile[k].empty()) product *= side.profile[k][static_cast<std::size_t>(2 * cell[k] + 1 - c[k])];
    return product;
}

//! Where populations are that come in: direction, and place from that of the cell.
struct Source
{
    std::size_t direction;
    std::array<std::ptrdiff_t, 3> place;
};

//! Populations of direction q on their way into cells, from beyond the sides along some axes.
template <int D>
struct Entry
{
    Walls const& walls;
    Extent const& cells;  //!< of the lattice
    std::size_t q;
    std::array<bool, 3> beyond;  //!< along which axes they come from outside
    std::array<int, 3> const& c = Lattice<D>::c[q];

    Boundary const& side_across(std::size_t axis) const { return walls.side[axis][c[axis] > 0 ? 0 : 1]; }

    //! The axis whose side throws them back, a wall at rest before others; -1: none, they were mirrored or come from
    //! the other side.
    int axis() const
    {
        int found = -1;
        for (int axis = D - 1; axis >= 0; --axis) {
            auto const k = static_cast<std::size_t>(axis);
            if (!beyond[k]) continue;
            Boundary const& side = side_across(k);
            if (side.rests()) return axis;
            if (found < 0 && side.kind != Border::periodic && side.kind != Border::slip) found = axis;
        }
        return found;
    }

    //! Of those that were thrown back at an axis(); -1: that left to where these come from, after mirrors and periodic
    //! sides.
    Source source(int across) const
    {
        if (across >= 0) return {Lattice<D>::opposite[q], {-c[0], -c[1], -c[2]}};
        std::array<int, 3> mirrored = c;
        std::array<std::ptrdiff_t, 3> place{};
        for (std::size_t k = 0; k < D; ++k) {
            if (!beyond[k]) continue;
            bool const slip = side_across(k).kind == Border::slip;
            if (slip) mirrored[k] = -c[k];
            place[k] = slip ? -c[k] : c[k] * cells[k];
        }
        auto const& all = Lattice<D>::c;
        return {static_cast<std::size_t>(std::find(all.begin(), all.end(), mirrored) - all.begin()), place};
    }
    //! Whether they come through an edge of two sides through which nothing flows.
    bool through_edge() const
    {
        int closed = 0;
        for (std::size_t k = 0; k < D; ++k) {
            if (!beyond[k]) continue;
            Border const kind = side_across(k).kind;
            closed += kind == Border::wall || kind == Border::slip;
        }
        return closed > 1;
    }
    //! What a moving wall or the fastest inflow adds.
    double push(Boundary const& side) const
    {
        return side.kind == Border::pressure || through_edge() ? 0.0
                                                               : 6.0 * Lattice<D>::weight[q] * dot(c, side.velocity);
    }
};

//! Finds the links of one row after another.
template <int D>
class EntranceFinder
{
 public:
    EntranceFinder(Walls const& walls, Layout const& layout, Surroundings const& around)
        : walls_(walls), layout_(layout), around_(around)
    {}

    std::vector<Crossing> const& crossings() const { return crossings_; }  //!< of all rows so far
    std::vector<Entrance> of_row(std::ptrdiff_t r)
    {
        links_.clear();
        Row const& row = layout_.row(r);
        Box const& box = layout_.boxes()[static_cast<std::size_t>(row.box)];
        auto const beside = [&](std::size_t k, std::ptrdiff_t at) {
            return at >= box.first[k] && at < box.first[k] + box.size[k];
        };
        for (std::size_t q = 1; q < Lattice<D>::directions; ++q) {
            auto const& c = Lattice<D>::c[q];
            bool const ends_only = beside(1, row.y - c[1]) && beside(2, row.z - c[2]);
            if (ends_only && c[0] == 0) continue;
            std::int32_t const begin = ends_only && c[0] < 0 ? row.cells - 1 : 0,
                               end = ends_only && c[0] > 0 ? 1 : row.cells;
            for (std::int32_t x = begin; x < end; ++x) add(q, r, x);
        }
        return links_;
    }

 private:
    void add(std::size_t q, std::ptrdiff_t r, std::int32_t x)
    {
        Row const& row = layout_.row(r);
        Extent left{};
        Entrance const link = find(q, {row.first + x, row.y, row.z}, row.box, x, left);
        if (link.box < 0) return add_crossing(static_cast<std::int32_t>(r), link, left);
        if (!links_.empty()) {
            Entrance& last = links_.back();
            Entrance next = last;
            next.x = last.x + last.cells;
            next.cells = 1;
            if (next == link) return static_cast<void>(++last.cells);
        }
        links_.push_back(link);
    }
    void add_crossing(std::int32_t r, Entrance const& link, Extent const& left)
    {
        std::int32_t const box = around_.elsewhere(left);
        if (!crossings_.empty()) {
            Crossing& last = crossings_.back();
            Extent next = last.left;
            next[0] += last.cells;
            if (last.row == r && last.into == link.into && last.from == link.from && last.box == box &&
                last.x + last.cells == link.x && next == left)
                return static_cast<void>(++last.cells);
        }
        crossings_.push_back({r, link.into, link.from, link.x, 1, box, left});
    }
    //! `left`: the cell that they left. The link's box is -1 if another process has that.
    Entrance find(std::size_t q, Extent const& cell, std::int32_t box, std::int32_t x, Extent& left) const
    {
        auto const& c = Lattice<D>::c[q];
        Extent const& n = layout_.cells();
        Entry<D> entry{walls_, n, q, {}};
        bool outside = false;
        for (std::size_t k = 0; k < D; ++k) {
            entry.beyond[k] = cell[k] - c[k] < 0 || cell[k] - c[k] >= n[k];
            outside = outside || entry.beyond[k];
        }
        int const across = outside ? entry.axis() : -1;
        Source const source = outside ? entry.source(across) : Source{q, {0, 0, 0}};
        Entrance link{.into = static_cast<std::uint8_t>(q),
                      .from = 0,
                      .kind = Border::periodic,
                      .x = x,
                      .cells = 1,
                      .box = box,
                      .place = {}};
        if (across >= 0) {
            Boundary const& side = entry.side_across(static_cast<std::size_t>(across));
            auto const beside = cell_beside(entry, cell, static_cast<std::size_t>(across));
            if (!side.rests() && beside && around_.elsewhere(*beside) < 0) link.patch = around_.solid_at(*beside);
            if (link.patch >= 0) return from_here(link, source);
            link.across = static_cast<std::uint8_t>(across);
            link.kind = side.kind;
            link.push = entry.push(side);
            bool const covered = around_.cover(cell) || (beside && around_.cover(*beside));
            if (!side.rests() && covered) link.kind = Border::wall, link.push = 0;
            return from_here(link, source);
        }
        for (std::size_t k = 0; k < 3; ++k) left[k] = cell[k] + source.place[k] - Lattice<D>::c[source.direction][k];
        link.box = layout_.box_of(left);
        if (link.box >= 0) return from_there(link, source, box);
        link.from = static_cast<std::uint8_t>(source.direction);
        if (around_.elsewhere(left) >= 0) return link;
        link.box = box;
        link.patch = around_.solid_at(left);
        return from_here(link, {Lattice<D>::opposite[q], {-c[0], -c[1], -c[2]}});
    }
    //! Through whose edge with a side a link comes into a cell, or the cell itself; none beyond another side. What
    //! rests there has the link, so that what a wall that moves takes away at one end it brings at the other.
    std::optional<Extent> cell_beside(Entry<D> const& entry, Extent cell, std::size_t across) const
    {
        for (std::size_t k = 0; k < D; ++k) {
            if (k == across) continue;
            cell[k] -= entry.c[k];
            if (!entry.beyond[k]) continue;
            if (!walls_.periodic()[k]) return std::nullopt;
            cell[k] = wrap(cell[k], layout_.cells()[k]);
        }
        return cell;
    }
    static Entrance from_here(Entrance link, Source const& source)
    {
        link.from = static_cast<std::uint8_t>(source.direction);
        for (std::size_t k = 0; k < 3; ++k) link.place[k] = static_cast<std::int32_t>(source.place[k]);
        return link;
    }
    Entrance from_there(Entrance link, Source const& source, std::int32_t here) const
    {
        Extent const &own = layout_.boxes()[static_cast<std::size_t>(here)].first,
                     &other = layout_.boxes()[static_cast<std::size_t>(link.box)].first;
        link = from_here(link, source);
        for (std::size_t k = 0; k < 3; ++k) link.place[k] += static_cast<std::int32_t>(own[k] - other[k]);
        return link;
    }

    Walls const& walls_;
    Layout const& layout_;
    Surroundings const& around_;
    std::vector<Entrance> links_;
    std::vector<Crossing> crossings_;
};

//! For each direction 2 e+(rho of the opening) + (2 - s) (f+ - e+(rho)) of a cell, + the even part, e the shifted
//! equilibrium.
template <int D, class Stored, class Density>
void note_cell(Rows<D, Stored> const& p, std::ptrdiff_t row, std::ptrdiff_t x, Walls const& walls,
               Density&& density_excess_of, double* turned)
{
    constexpr std::size_t directions = Lattice<D>::directions;
    std::array<double, directions> f;
    double excess = 0;
    std::array<double, 3> j = walls.half_force;
    for (std::size_t q = 0; q < directions; ++q) {
        f[q] = p.row(q, row)[x];
        excess += f[q];
        for (std::size_t k = 0; k < 3; ++k) j[k] += Lattice<D>::c[q][k] * f[q];
    }
    std::array<double, D> u, back;
    for (std::size_t k = 0; k < D; ++k) {
        u[k] = j[k] / (1 + excess);
        back[k] = -u[k];
    }
    double const density_excess = density_excess_of(excess, u);
    auto const even = [&](std::size_t q, double of) {
        return 0.5 * (equilibrium<D>(q, of, u) + equilibrium<D>(q, of, back));
    };
    for (std::size_t q = 0; q < directions; ++q)
        turned[q] = 2 * even(q, density_excess) +
                    (2 - walls.even_rate) * (0.5 * (f[q] + f[Lattice<D>::opposite[q]]) - even(q, excess));
}

//! At an opening that absorbs sound, of a cell that flows outward with u.
double absorbed(Boundary const& side, double excess, double u, double& incoming, Incoming how)
{
    double const sound = 1 / std::numbers::sqrt3, pressure = excess / 3, outgoing = pressure + sound * u;
    if (how == Incoming::found) incoming = pressure - sound * u;
    if (how == Incoming::recalled) incoming -= side.recall * (0.5 * (outgoing + incoming) - side.density_excess / 3);
    return 1.5 * (outgoing + incoming);
}

}  // namespace

template <int D>
Entrances find_entrances(Walls const& walls, Layout const& layout, Surroundings const& around)
{
    Entrances all;
    EntranceFinder<D> finder(walls, layout, around);
    std::map<std::size_t, std::vector<std::uint32_t>> alike;  // by number of links
    for (std::ptrdiff_t r = 0; r < layout.rows(); ++r) {
        auto links = finder.of_row(r);
        auto& candidates = alike[links.size()];
        auto const found = std::find_if(candidates.rbegin(), candidates.rend(),
                                        [&](std::uint32_t kind) { return all.kinds[kind] == links; });
        if (found != candidates.rend()) {
            all.kind_of.push_back(*found);
            continue;
        }
        candidates.push_back(static_cast<std::uint32_t>(all.kinds.size()));
        all.kind_of.push_back(candidates.back());
        all.kinds.push_back(std::move(links));
    }
    all.crossings = finder.crossings();
    return all;
}

namespace {

//! Where a row is in its box.
template <int D, class Stored>
std::array<std::ptrdiff_t, 2> place_in_box(Rows<D, Stored> const& p, std::ptrdiff_t r)
{
    Row const& row = p.layout().row(r);
    Extent const& first = p.layout().boxes()[static_cast<std::size_t>(row.box)].first;
    return {row.y - first[1], row.z - first[2]};
}

//! Whether a link's population left a row at one of its ends: then it is taken from where that was noted.
template <int D, class Stored>
bool left_at_end(Rows<D, Stored> const& p, Entrance const& link)
{
    int const along = Lattice<D>::c[link.from][0];
    Extent const& size = p.layout().boxes()[static_cast<std::size_t>(link.box)].size;
    return along != 0 && link.cells == 1 && link.x + link.place[0] == (along > 0 ? size[0] : -1);
}

}  // namespace

template <int D, class Stored>
Stored const* source(Rows<D, Stored> const& p, std::ptrdiff_t r, Entrance const& link)
{
    auto const [y, z] = place_in_box(p, r);
    auto const box = static_cast<std::size_t>(link.box);
    std::ptrdiff_t const from_y = y + link.place[1], from_z = z + link.place[2];
    if (!left_at_end(p, link)) return p.at(box, link.from, from_y, from_z) + link.x + link.place[0];
    auto const& c = Lattice<D>::c[link.from];
    return p.end(link.from,
                 p.layout().first_row(box) + (from_z - c[2]) * p.layout().boxes()[box].size[1] + from_y - c[1]);
}

template <int D, class Stored>
Stored const* comes_from_end(Rows<D, Stored> const& p, std::ptrdiff_t r, Entrance const& link)
{
    bool const first = link.x == 0 && Lattice<D>::c[link.into][0] > 0,
               last = link.x == p.nx(r) - 1 && Lattice<D>::c[link.into][0] < 0;
    bool const plain = link.kind != Border::inflow && link.kind != Border::pressure;
    return (first || last) && plain && left_at_end(p, link) ? source(p, r, link) : nullptr;
}

template <int D, class Stored>
void enter_link(Rows<D, Stored> const& p, std::ptrdiff_t r, Entrance const& link, Walls const& walls, Stored const* out)
{
    Layout const& layout = p.layout();
    Row const& row = layout.row(r);
    Stored* const in = p.row(link.into, r) + link.x;
    Boundary const& side = walls.side[link.across][Lattice<D>::c[link.into][link.across] > 0 ? 0 : 1];
    auto const cell = [&](std::ptrdiff_t k) { return Extent{row.first + link.x + k, row.y, row.z}; };
    if (link.kind == Border::inflow) {
        for (std::ptrdiff_t k = 0; k < link.cells; ++k)
            in[k] =
                static_cast<Stored>(out[k] + side.share * profile(side, Lattice<D>::c[link.into], cell(k)) * link.push);
    } else if (link.kind == Border::pressure) {
        for (std::ptrdiff_t k = 0; k < link.cells; ++k)
            in[k] = static_cast<Stored>(
                side.turned[Lattice<D>::directions * place_beside(layout.cells(), link.across, cell(k)) + link.into] -
                out[k]);
    } else if (link.push == 0) {
        std::copy_n(out, link.cells, in);
    } else {
        double const push = link.push;
        for (std::ptrdiff_t k = 0; k < link.cells; ++k) in[k] = static_cast<Stored>(out[k] + push);
    }
}

namespace {

//! One cell of each row from `begin` to `end`, one above the other in a box. Each is far from the last in memory: next
//! to nothing is done between two, so that the machine waits for many at once.
template <int D, class Stored>
void enter_column(Rows<D, Stored> const& p, std::ptrdiff_t begin, std::ptrdiff_t end, Entrance const& link)
{
    auto const [y, z] = place_in_box(p, begin);
    auto in = p.column(static_cast<std::size_t>(p.layout().row(begin).box), link.into, y, z);
    if (left_at_end(p, link)) {
        Stored const* left = source(p, begin, link);
        for (std::ptrdiff_t r = begin; r < end; ++r, in.up(), left += along_x<D>)
            in.first()[link.x] = static_cast<Stored>(*left + link.push);
        return;
    }
    auto out = p.column(static_cast<std::size_t>(link.box), link.from, y + link.place[1], z + link.place[2]);
    std::ptrdiff_t const from = link.x + link.place[0];
    for (std::ptrdiff_t r = begin; r < end; ++r, in.up(), out.up())
        in.first()[link.x] = static_cast<Stored>(out.first()[from] + link.push);
}

}  // namespace

template <int D, class Stored>
void enter_from_outside(Rows<D, Stored> const& p, std::ptrdiff_t begin, std::ptrdiff_t end, Walls const& walls)
{
    auto const alike = [&](std::ptrdiff_t r, std::ptrdiff_t other) {
        Row const &a = p.layout().row(r), &b = p.layout().row(other);
        return a.box == b.box && a.z == b.z && &walls.entrances.of_row(r) == &walls.entrances.of_row(other);
    };
    for (std::ptrdiff_t next = begin; begin < end; begin = next) {
        while (next < end && alike(begin, next)) ++next;
        for (Entrance const& link : walls.entrances.of_row(begin)) {
            if (link.cells == 1 && link.kind != Border::inflow && link.kind != Border::pressure) {
                enter_column(p, begin, next, link);
                continue;
            }
            for (std::ptrdiff_t r = begin; r < next; ++r) enter_link(p, r, link, walls, source(p, r, link));
        }
    }
}

template <int D, class Stored>
void note_turned(Rows<D, Stored> const& p, std::ptrdiff_t r, Walls& walls, Incoming incoming)
{
    for (std::size_t k = 0; k < D; ++k)
        for (std::size_t end = 0; end < 2; ++end) {
            Boundary& side = walls.side[k][end];
            if (side.kind != Border::pressure) continue;
            each_beside<D>(p.layout(), r, k, end == 1, [&](std::ptrdiff_t x, std::size_t place) {
                auto const density_excess = [&](double excess, std::array<double, D> const& u) {
                    if (side.incoming.empty()) return side.density_excess;
                    auto const& [held, velocity] = side.held[place];
                    double const outward = (1 - held) * (end == 0 ? -u[k] : u[k]) + velocity;
                    return absorbed(side, excess, outward, side.incoming[place], incoming);
                };
                note_cell(p, r, x, walls, density_excess, side.turned.data() + Lattice<D>::directions * place);
            });
        }
}

template Entrances find_entrances<2>(Walls const&, Layout const&, Surroundings const&);
template Entrances find_entrances<3>(Walls const&, Layout const&, Surroundings const&);
#define LBM_WALLS(D, Stored)                                                                                        \
    template Stored const* comes_from_end(Rows<D, Stored> const&, std::ptrdiff_t, Entrance const&);                 \
    template void enter_link(Rows<D, Stored> const&, std::ptrdiff_t, Entrance const&, Walls const&, Stored const*); \
    template Stored const* source(Rows<D, Stored> const&, std::ptrdiff_t, Entrance const&);                         \
    template void enter_from_outside(Rows<D, Stored> const&, std::ptrdiff_t, std::ptrdiff_t, Walls const&);         \
    template void note_turned(Rows<D, Stored> const&, std::ptrdiff_t, Walls&, Incoming);
LBM_WALLS(2, double)
LBM_WALLS(2, float)
LBM_WALLS(3, double)
LBM_WALLS(3, float)
#undef LBM_WALLS

}  // namespace lbm
