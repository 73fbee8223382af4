#include "participants/lbm/fields.hpp"

#include <algorithm>
#include <cmath>

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
};

//! Excess, fraction, velocity and vorticity of a block of k cells each way.
template <int D>
std::array<double, 2 + D + spins<D>> mean_over(Cells<D> const& c, Extent const& block, std::ptrdiff_t k)
{
    std::array<double, 2 + D + spins<D>> sum{};
    double cells = 0;
    auto const end = [&](std::size_t axis) { return std::min(block[axis] * k + k, c.n[axis]); };
    for (std::ptrdiff_t z = block[2] * k; z < end(2); ++z)
        for (std::ptrdiff_t y = block[1] * k; y < end(1); ++y)
            for (std::ptrdiff_t x = block[0] * k; x < end(0); ++x) {
                std::size_t const at = c.index({x, y, z});
                auto const curl = c.curl({x, y, z});
                sum[0] += c.excess[at];
                sum[1] += c.fraction[at];
                for (std::size_t axis = 0; axis < D; ++axis) sum[2 + axis] += c.velocity[axis][at];
                for (std::size_t axis = 0; axis < spins<D>; ++axis) sum[2 + D + axis] += curl[axis];
                cells += 1;
            }
    for (double& value : sum) value /= cells;
    return sum;
}

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
        bool const forces =
            config_.surface == Surface::forced && s.body < static_cast<std::ptrdiff_t>(covering().size());
        for (std::ptrdiff_t k = 0; k < s.count; ++k) {
            auto const x = static_cast<std::size_t>(s.begin + k);
            row.fraction[x] += s.fraction[k];
            (forces ? forced : drag)[x] += s.fraction[k] * (forces ? 1.0 : s.drag);
            for (std::size_t axis = 0; axis < D; ++axis)
                solid[axis][x] += s.fraction[k] * velocity.at(axis, static_cast<int>(k));
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

template <int D>
Fields Solver<D>::fields(int coarsen)
{
    complete();
    if (links_ && steps_ == 0)
        links_->restore(bodies_, id_, walls_.half_force, std::vector<double>(bodies_.size(), 0.0));
    coverage_.update(covering(), team_);
    std::ptrdiff_t const k = std::max(coarsen, 1);
    auto const blocks = [&](std::ptrdiff_t n) { return (n + k - 1) / k; };
    constexpr std::size_t last = D - 1;
    Cells<D> c{.n = layout_.cells(), .periodic = walls_.periodic(), .layers = k + 2};
    ForeignLayers<D> foreign(domain_, c.periodic[last], k,
                             [&](std::ptrdiff_t r, RowState<D>& row) { read_row(r, row); });
    RowState<D> row;
    auto const take_layer = [&](std::ptrdiff_t layer) {
        c.clear(layer);
        std::ptrdiff_t const at = wrap(layer, c.n[last]);
        auto const put = [&](Row const& place) {
            Extent cell{place.first, place.y, 0};
            cell[last] = layer;
            c.put(cell, row);
        };
        if (foreign.has(at))
            return each_row_of_layer<D>(domain_.whole(), at, [&](std::ptrdiff_t r) {
                foreign.take(at, domain_.whole().row(r).cells, row);
                put(domain_.whole().row(r));
            });
        each_row_of_layer<D>(layout_, at, [&](std::ptrdiff_t r) {
            read_row(r, row);
            put(layout_.row(r));
        });
    };
    auto const [first_block, last_block] = blocks_of(domain_, domain_.rank(), k);
    std::ptrdiff_t taken = std::max<std::ptrdiff_t>(first_block * k - 1, c.periodic[last] ? -1 : 0);  // layers before
    auto const take_up_to = [&](std::ptrdiff_t layer) {
        for (; taken <= std::min(layer, c.periodic[last] ? c.n[last] : c.n[last] - 1); ++taken) take_layer(taken);
    };
    Fields out;
    out.nx = blocks(c.n[0]), out.ny = blocks(c.n[1]), out.nz = blocks(c.n[2]);
    out.spacing = static_cast<double>(k) * config_.cell;
    LatticeUnits const unit = config_.units();
    for (std::ptrdiff_t z = D == 2 ? 0 : first_block; z < (D == 2 ? 1 : last_block); ++z)
        for (std::ptrdiff_t y = D == 2 ? first_block : 0; y < (D == 2 ? last_block : out.ny); ++y) {
            take_up_to((D == 2 ? y : z) * k + k);
            for (std::ptrdiff_t x = 0; x < out.nx; ++x) {
                auto const value = mean_over(c, {x, y, z}, k);
                out.pressure.push_back(unit.pressure(value[0]));
                out.solid_fraction.push_back(value[1]);
                for (std::size_t axis = 0; axis < D; ++axis)
                    out.velocity.push_back(value[2 + axis] * unit.velocity_unit());
                for (std::size_t axis = 0; axis < spins<D>; ++axis)
                    out.vorticity.push_back(value[2 + D + axis] / config_.step);
            }
        }
    if (auto* const peers = domain_.peers())
        for (auto* v : {&out.velocity, &out.pressure, &out.vorticity, &out.solid_fraction})
            ranks::join_on_first(*peers, *v);
    return out;
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
template Fields Solver<2>::fields(int);
template Fields Solver<3>::fields(int);
template double Solver<2>::max_speed();
template double Solver<3>::max_speed();

}  // namespace lbm
