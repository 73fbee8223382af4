#include "participants/lbm/fields.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include "participants/lbm/foreign_layers.hpp"
#include "participants/lbm/solid_weight.hpp"
#include "participants/lbm/solver.hpp"

namespace lbm {
namespace {

//! Cell values, lattice units, before they are averaged: of some layers of cells, one row in the plane, one plane in
//! space, that follow each other along the last axis. Layers beyond a periodic side are those of the other end. Cells
//! that are not stored are solid at rest.
template <int D>
struct Cells
{
    static constexpr std::size_t last = D - 1;  //!< axis
    Extent n;
    std::array<bool, 3> periodic;
    std::ptrdiff_t layers;  //!< held
    std::vector<double> excess{}, fraction{};
    std::array<std::vector<double>, D> velocity{};

    std::size_t layer_size() const { return static_cast<std::size_t>(D == 2 ? n[0] : n[0] * n[1]); }
    std::size_t index(Extent const& at) const
    {
        auto const layer = static_cast<std::size_t>((at[last] + layers) % layers);
        return layer * layer_size() + static_cast<std::size_t>(D == 2 ? at[0] : at[1] * n[0] + at[0]);
    }
    //! Lets a layer be solid at rest.
    void clear(std::ptrdiff_t layer)
    {
        std::size_t const size = layer_size();
        Extent at{};
        at[last] = layer;
        auto const first = static_cast<std::ptrdiff_t>(index(at));
        auto const fill = [&](std::vector<double>& v, double value) {
            v.resize(size * static_cast<std::size_t>(layers));
            std::fill_n(v.begin() + first, size, value);
        };
        fill(excess, 0);
        fill(fraction, 1);
        for (auto& component : velocity) fill(component, 0);
    }
    //! From a cell on along x.
    void put(Extent const& cell, RowState<D> const& row)
    {
        auto const first = static_cast<std::ptrdiff_t>(index(cell));
        std::ranges::copy(row.excess, excess.begin() + first);
        std::ranges::copy(row.fraction, fraction.begin() + first);
        for (std::size_t axis = 0; axis < D; ++axis)
            std::ranges::copy(row.velocity[axis], velocity[axis].begin() + first);
    }
    //! d u_a / d x_b by differences of the neighbours; one-sided at an end unless periodic.
    double gradient(std::size_t a, std::size_t b, Extent const& at) const
    {
        std::ptrdiff_t const i = at[b], count = n[b];
        auto const value = [&](std::ptrdiff_t k) {
            Extent there = at;
            there[b] = b == last ? k : (k + count) % count;
            return velocity[a][index(there)];
        };
        if (count < 2) return 0;
        if (periodic[b]) return 0.5 * (value(i + 1) - value(i - 1));
        if (i == 0) return value(1) - value(0);
        if (i == count - 1) return value(count - 1) - value(count - 2);
        return 0.5 * (value(i + 1) - value(i - 1));
    }
    std::array<double, spins<D>> curl(Extent const& at) const
    {
        double const z = gradient(1, 0, at) - gradient(0, 1, at);
        if constexpr (D == 2)
            return {z};
        else
            return {gradient(2, 1, at) - gradient(1, 2, at), gradient(0, 2, at) - gradient(2, 0, at), z};
    }
    double q_criterion(Extent const& at) const
    {
        double sum = 0;
        for (std::size_t a = 0; a < D; ++a)
            for (std::size_t b = 0; b < D; ++b) sum += gradient(a, b, at) * gradient(b, a, at);
        return -0.5 * sum;
    }
};

//! Layer after layer of a process's cells, with those beside them, in blocks of k layers.
template <int D>
class LayerWalk
{
 public:
    using Read = std::function<void(std::ptrdiff_t r, RowState<D>&)>;

    //! `read`: the state of one of our rows. All processes together.
    LayerWalk(Domain<D> const& domain, std::array<bool, 3> periodic, std::ptrdiff_t k, Read read)
        : cells{.n = domain.whole().cells(), .periodic = periodic, .layers = k + 2},
          domain_(domain),
          read_(std::move(read)),
          foreign_(domain, periodic[D - 1], k, read_),
          blocks_(blocks_of(domain, domain.rank(), k)),
          taken_(std::max<std::ptrdiff_t>(blocks_[0] * k - 1, periodic[D - 1] ? -1 : 0))
    {}

    Cells<D> cells;
    std::array<std::ptrdiff_t, 2> blocks() const { return blocks_; }  //!< begin and end of ours
    //! Lets `cells` hold what a block's cells need.
    void take_up_to(std::ptrdiff_t layer)
    {
        std::ptrdiff_t const n = cells.n[D - 1];
        for (; taken_ <= std::min(layer, cells.periodic[D - 1] ? n : n - 1); ++taken_) take(taken_);
    }

 private:
    void take(std::ptrdiff_t layer)
    {
        cells.clear(layer);
        std::ptrdiff_t const at = wrap(layer, cells.n[D - 1]);
        auto const put = [&](Row const& place) {
            Extent cell{place.first, place.y, 0};
            cell[D - 1] = layer;
            cells.put(cell, row_);
        };
        if (foreign_.has(at))
            return each_row_of_layer<D>(domain_.whole(), at, [&](std::ptrdiff_t r) {
                foreign_.take(at, domain_.whole().row(r).cells, row_);
                put(domain_.whole().row(r));
            });
        each_row_of_layer<D>(domain_.own(), at, [&](std::ptrdiff_t r) {
            read_(r, row_);
            put(domain_.own().row(r));
        });
    }

    Domain<D> const& domain_;
    Read read_;
    ForeignLayers<D> foreign_;
    std::array<std::ptrdiff_t, 2> blocks_;
    std::ptrdiff_t taken_;  //!< layers before
    RowState<D> row_;
};

//! Means over a block of cells, lattice units.
template <int D>
struct Block
{
    double excess = 0, fraction = 0, q_criterion = 0;
    std::array<double, D> velocity{};
    std::array<double, spins<D>> vorticity{};

    //! k cells each way.
    Block(Cells<D> const& c, Extent const& block, std::ptrdiff_t k, FieldChoice const& choice)
    {
        double cells = 0;
        auto const end = [&](std::size_t axis) { return std::min(block[axis] * k + k, c.n[axis]); };
        for (std::ptrdiff_t z = block[2] * k; z < end(2); ++z)
            for (std::ptrdiff_t y = block[1] * k; y < end(1); ++y)
                for (std::ptrdiff_t x = block[0] * k; x < end(0); ++x, cells += 1) add(c, {x, y, z}, choice);
        for (auto* value : {&excess, &fraction, &q_criterion}) *value /= cells;
        for (double& value : velocity) value /= cells;
        for (double& value : vorticity) value /= cells;
    }

 private:
    void add(Cells<D> const& c, Extent const& cell, FieldChoice const& choice)
    {
        std::size_t const at = c.index(cell);
        excess += c.excess[at];
        fraction += c.fraction[at];
        for (std::size_t axis = 0; axis < D; ++axis) velocity[axis] += c.velocity[axis][at];
        if (choice.q_criterion) q_criterion += c.q_criterion(cell);
        if (!choice.vorticity) return;
        auto const curl = c.curl(cell);
        for (std::size_t axis = 0; axis < spins<D>; ++axis) vorticity[axis] += curl[axis];
    }
};

}  // namespace

//! Density excess, and momentum in the place of velocity.
template <int D>
void Solver<D>::read_moments(std::ptrdiff_t r, RowState<D>& row) const
{
    using L = Lattice<D>;
    auto const n = static_cast<std::size_t>(layout_.row(r).cells);
    row.excess.assign(n, 0.0);
    for (auto& v : row.velocity) v.assign(n, 0.0);
    populations_.visit([&](auto const& rows) {
        for (std::size_t q = 0; q < L::directions; ++q) {
            auto const* const f = rows.row(q, r);
            for (std::size_t x = 0; x < n; ++x) row.excess[x] += f[x];
            for (std::size_t axis = 0; axis < D; ++axis)
                if (double const c = L::c[q][axis]; c != 0)
                    for (std::size_t x = 0; x < n; ++x) row.velocity[axis][x] += c * f[x];
        }
    });
}

//! Lattice units. In a covered cell the velocity is (1 - B) u + B u_s: the mean of the cell's momentum before and after
//! the collision, hence what flows through it (B without its ease by inertia).
template <int D>
void Solver<D>::read_row(std::ptrdiff_t r, RowState<D>& row) const
{
    auto const n = static_cast<std::size_t>(layout_.row(r).cells);
    std::array<std::vector<double>, D> solid;
    std::vector<double> drag(n, 0.0), forced(n, 0.0);
    row.fraction.assign(n, 0.0);
    for (auto& v : solid) v.assign(n, 0.0);
    for (std::uint32_t const index : coverage_.row(r)) {
        Strip<D> const& s = coverage_.strips()[index];
        StripVelocity<D> const velocity(s, covering());
        bool const forces = is_forced(s);
        for (std::ptrdiff_t k = 0; k < s.count; ++k) {
            auto const x = static_cast<std::size_t>(s.begin + k);
            double const fraction = s.fraction(k);
            row.fraction[x] += fraction;
            (forces ? forced : drag)[x] += fraction * (forces ? 1.0 : s.drag);
            for (std::size_t axis = 0; axis < D; ++axis)
                solid[axis][x] += fraction * velocity.template at<double>(axis, static_cast<int>(k));
        }
    }
    Relaxation const relaxation = of_row(r);
    read_moments(r, row);
    for (std::size_t x = 0; x < n; ++x) {
        std::array<double, 3> j{};
        for (std::size_t axis = 0; axis < 3; ++axis)
            j[axis] = 0.5 * (relaxation.force[axis] + relaxation.slope[axis] * static_cast<double>(x));
        for (std::size_t axis = 0; axis < D; ++axis) j[axis] += row.velocity[axis][x];
        double const share = weight_beside_forced(forced[x], row.fraction[x] - forced[x], drag[x], relaxation_.tau);
        double const fluid = 1 - share * row.fraction[x];
        typename Phase<D>::Cell fine;
        double const rho = 1 + row.excess[x];
        if (phase_) fine = phase_->cell(r, static_cast<std::ptrdiff_t>(x), j, rho);
        if (turning_) turn_with_half(relaxation.turn, j[0], j[1], j[2]);
        for (std::size_t axis = 0; axis < D; ++axis)
            row.velocity[axis][x] =
                (fluid - fine.weight) * j[axis] / rho + share * solid[axis][x] + fine.weight * fine.velocity[axis];
        row.fraction[x] += fine.solid;
        if (links_ && links_->covers(r, static_cast<std::ptrdiff_t>(x))) row.fraction[x] = 1.0;
        row.fraction[x] = std::min(row.fraction[x], 1.0);
    }
}

//! Lets rows be read as they are now.
template <int D>
void Solver<D>::prepare_to_read()
{
    complete();
    if (links_ && steps_ == 0)
        links_->restore(bodies_, id_, walls_.half_force, std::vector<double>(bodies_.size(), 0.0));
    coverage_.update(covering(), team_);
}

template <int D>
Fields Solver<D>::fields(int coarsen, FieldChoice const& choice)
{
    prepare_to_read();
    std::ptrdiff_t const k = std::max(coarsen, 1);
    LayerWalk<D> walk(domain_, walls_.periodic(), k, [&](std::ptrdiff_t r, RowState<D>& row) { read_row(r, row); });
    auto const blocks = [&](std::size_t axis) { return (walk.cells.n[axis] + k - 1) / k; };
    Fields out;
    out.nx = blocks(0), out.ny = blocks(1), out.nz = blocks(2);
    out.spacing = static_cast<double>(k) * config_.cell;
    LatticeUnits const unit = config_.units();
    auto const append = [&](Extent const& place) {
        Block<D> const block(walk.cells, place, k, choice);
        if (choice.pressure) out.pressure.push_back(unit.pressure(block.excess));
        if (choice.solid_fraction) out.solid_fraction.push_back(block.fraction);
        if (choice.velocity)
            for (double const u : block.velocity) out.velocity.push_back(u * unit.velocity_unit());
        if (choice.vorticity)
            for (double const w : block.vorticity) out.vorticity.push_back(w / config_.step);
        if (choice.q_criterion) out.q_criterion.push_back(block.q_criterion / (config_.step * config_.step));
    };
    auto const [first, last] = walk.blocks();
    for (std::ptrdiff_t z = D == 2 ? 0 : first; z < (D == 2 ? 1 : last); ++z)
        for (std::ptrdiff_t y = D == 2 ? first : 0; y < (D == 2 ? last : out.ny); ++y) {
            walk.take_up_to((D == 2 ? y : z) * k + k);
            for (std::ptrdiff_t x = 0; x < out.nx; ++x) append({x, y, z});
        }
    if (auto* const peers = domain_.peers())
        for (auto* v : {&out.velocity, &out.pressure, &out.vorticity, &out.solid_fraction, &out.q_criterion})
            ranks::join_on_first(*peers, *v);
    return out;
}

template <int D>
Energies Solver<D>::energies()
{
    prepare_to_read();
    LayerWalk<D> walk(domain_, walls_.periodic(), 1, [&](std::ptrdiff_t r, RowState<D>& row) { read_row(r, row); });
    Cells<D> const& c = walk.cells;
    std::vector<SumPart<2>> parts;
    auto const [first, last] = walk.blocks();
    for (std::ptrdiff_t layer = first; layer < last; ++layer) {
        walk.take_up_to(layer + 1);
        SumPart<2> part{0, layer, {}};
        for (std::ptrdiff_t y = D == 2 ? layer : 0; y < (D == 2 ? layer + 1 : c.n[1]); ++y)
            for (std::ptrdiff_t x = 0; x < c.n[0]; ++x) {
                Extent const cell{x, y, D == 2 ? 0 : layer};
                std::size_t const at = c.index(cell);
                double const half = 0.5 * (1 - c.fraction[at]);
                for (auto const& component : c.velocity)
                    part.sum[0] += half * (1 + c.excess[at]) * component[at] * component[at];
                for (double const w : c.curl(cell)) part.sum[1] += half * w * w;
            }
        parts.push_back(part);
    }
    auto const [kinetic, enstrophy] = domain_.totals(parts, 1)[0];
    double const speed = config_.units().velocity_unit(), volume = std::pow(config_.cell, D);
    return {kinetic * config_.units().mass_unit() * speed * speed, enstrophy * volume / (config_.step * config_.step)};
}

//! Linear between the centres of cells; within half a cell of a side that is not periodic as there.
template <int D>
std::vector<Sample<D>> Solver<D>::samples(std::span<std::array<double, D> const> places)
{
    prepare_to_read();
    std::map<std::ptrdiff_t, RowState<D>> read;  // rows that are needed
    auto const periodic = walls_.periodic();
    Extent const& n = layout_.cells();
    constexpr std::size_t numbers = 3 + D;  // weight of stored cells; times excess, open share and velocity
    std::vector<SumPart<numbers>> parts;
    auto const add = [&](std::size_t which, std::ptrdiff_t layer, Extent const& cell, double weight) {
        for (std::uint32_t const r : layout_.across(cell[1], cell[2])) {
            std::ptrdiff_t const x = cell[0] - layout_.row(r).first;
            if (weight == 0 || x < 0 || x >= layout_.row(r).cells) continue;
            auto const [row, is_new] = read.try_emplace(r);
            if (is_new) read_row(r, row->second);
            RowState<D> const& state = row->second;
            auto const at = static_cast<std::size_t>(x);
            SumPart<numbers> part{which, layer, {weight, weight * state.excess[at], weight * (1 - state.fraction[at])}};
            for (std::size_t k = 0; k < D; ++k) part.sum[3 + k] = weight * state.velocity[k][at];
            parts.push_back(part);
        }
    };
    for (std::size_t p = 0; p < places.size(); ++p) {
        std::array<std::array<std::ptrdiff_t, 2>, 3> cells{};
        std::array<std::array<double, 2>, 3> weights{{{1, 0}, {1, 0}, {1, 0}}};
        for (std::size_t k = 0; k < D; ++k) {
            double const at = (places[p][k] - config_.origin[k]) / config_.cell - 0.5, floor = std::floor(at);
            weights[k] = {1 - (at - floor), at - floor};
            for (std::ptrdiff_t side = 0; side < 2; ++side) {
                std::ptrdiff_t const cell = static_cast<std::ptrdiff_t>(floor) + side;
                cells[k][static_cast<std::size_t>(side)] =
                    periodic[k] ? wrap(cell, n[k]) : std::clamp<std::ptrdiff_t>(cell, 0, n[k] - 1);
            }
        }
        for (std::size_t corner = 0; corner < (D == 2 ? 4 : 8); ++corner) {
            std::size_t const x = corner & 1, y = corner >> 1 & 1, z = corner >> 2;
            add(p, static_cast<std::ptrdiff_t>(D == 2 ? y : z), {cells[0][x], cells[1][y], cells[2][z]},
                weights[0][x] * weights[1][y] * weights[2][z]);
        }
    }
    std::vector<Sample<D>> samples;
    for (auto const& sum : domain_.totals(parts, places.size())) {
        Sample<D> sample{.velocity = {},
                         .pressure = config_.units().pressure(sum[0] > 0 ? sum[1] / sum[0] : 0.0),
                         .solid_fraction = 1 - sum[2]};
        for (std::size_t k = 0; k < D; ++k) sample.velocity[k] = sum[3 + k] * config_.units().velocity_unit();
        samples.push_back(sample);
    }
    return samples;
}

template <int D>
double Solver<D>::max_speed()
{
    complete();
    RowState<D> row;
    double largest = 0;
    for (std::ptrdiff_t r = 0; r < layout_.rows(); ++r) {
        read_row(r, row);
        for (std::size_t x = 0; x < row.excess.size(); ++x) {
            double square = 0;
            for (auto const& component : row.velocity) square += component[x] * component[x];
            largest = std::max(largest, square);
        }
    }
    if (auto* const peers = domain_.peers()) largest = std::ranges::max(peers->numbers(largest));
    return std::sqrt(largest) * config_.units().velocity_unit();
}

template void Solver<2>::read_row(std::ptrdiff_t, RowState<2>&) const;
template void Solver<3>::read_row(std::ptrdiff_t, RowState<3>&) const;
template Fields Solver<2>::fields(int, FieldChoice const&);
template Fields Solver<3>::fields(int, FieldChoice const&);
template Energies Solver<2>::energies();
template Energies Solver<3>::energies();
template std::vector<Sample<2>> Solver<2>::samples(std::span<std::array<double, 2> const>);
template std::vector<Sample<3>> Solver<3>::samples(std::span<std::array<double, 3> const>);
template double Solver<2>::max_speed();
template double Solver<3>::max_speed();

}  // namespace lbm
