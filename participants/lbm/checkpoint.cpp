// Solver: all that it needs to go on bit for bit, as named arrays.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

#include "coupler/base/error.hpp"
#include "participants/lbm/solver.hpp"

namespace lbm {
namespace {

std::string populations_name(std::size_t q)
{
    return "populations/" + std::to_string(q);
}

//! Rows of K numbers each to one array, and back.
template <std::size_t K, class Rows, class Numbers>
void put_rows(sluice::State& kept, char const* name, Rows const& rows, Numbers numbers_of)
{
    std::vector<double> values;
    for (auto const& row : rows) {
        std::array<double, K> const numbers = numbers_of(row);
        values.insert(values.end(), numbers.begin(), numbers.end());
    }
    kept.put(name, std::span<double const>(values));
}

template <std::size_t K, class Row, class Make>
std::vector<Row> take_rows(sluice::State const& kept, char const* name, std::size_t count, Make make)
{
    auto const values = kept.numbers(name, K * count);
    std::vector<Row> rows;
    for (std::size_t i = 0; i < count; ++i) rows.push_back(make(values.data() + K * i));
    return rows;
}

void put_ids(sluice::State& kept, char const* name, std::vector<std::uint64_t> const& ids)
{
    std::vector<std::int64_t> const values(ids.begin(), ids.end());
    kept.put(name, std::span<std::int64_t const>(values));
}

std::vector<std::uint64_t> take_ids(sluice::State const& kept, char const* name)
{
    auto const values = kept.integers(name);
    return {values.begin(), values.end()};
}

}  // namespace

template <int D>
void Solver<D>::keep(sluice::State& kept)
{
    constexpr std::size_t place = 2 * D + 1 + spins<D>;
    complete();
    kept.put_integer("steps", steps_);
    put_ids(kept, "bodies/id", id_);
    put_rows<place>(kept, "bodies/place", bodies_, [](Body<D> const& b) {
        std::array<double, place> numbers;
        auto at = std::copy(b.centre.begin(), b.centre.end(), numbers.begin());
        *at++ = b.radius;
        at = std::copy(b.velocity.begin(), b.velocity.end(), at);
        std::copy(b.spin.begin(), b.spin.end(), at);
        return numbers;
    });
    put_rows<2 + freedoms>(kept, "bodies/displaced", displaced_, [](Displaced const& d) {
        std::array<double, 2 + freedoms> numbers{d.mass, d.gyration};
        std::copy(d.motion.begin(), d.motion.end(), numbers.begin() + 2);
        return numbers;
    });
    put_ids(kept, "last/id", last_id_);
    put_rows<freedoms>(kept, "last/velocity", past_, [](Past const& p) { return p.motion; });
    put_rows<freedoms>(kept, "last/exchange", past_, [](Past const& p) { return p.exchange; });
    if (phase_) phase_->keep(kept);
    if (!solid_exchange_.empty())
        put_rows<freedoms>(kept, "solids/exchange", solid_exchange_, [](Motion const& m) { return m; });
    std::vector<double> cells;
    cells.reserve(static_cast<std::size_t>(populations_.cells()));
    for (std::size_t q = 0; q < Lattice<D>::directions; ++q) {
        cells.clear();
        for (std::ptrdiff_t r = 0; r < populations_.rows(); ++r)
            cells.insert(cells.end(), populations_.row(q, r), populations_.row(q, r) + populations_.nx());
        kept.put(populations_name(q), std::span<double const>(cells));
    }
}

//! Everything is taken out before anything changes: what does not fit leaves the solver as it was.
template <int D>
void Solver<D>::restore(sluice::State const& kept)
{
    constexpr std::size_t place = 2 * D + 1 + spins<D>;
    auto const cells = static_cast<std::size_t>(populations_.cells());
    auto id = take_ids(kept, "bodies/id"), last_id = take_ids(kept, "last/id");
    auto bodies = take_rows<place, Body<D>>(kept, "bodies/place", id.size(), [](double const* v) {
        Body<D> b;
        std::copy_n(v, D, b.centre.begin());
        b.radius = v[D];
        std::copy_n(v + D + 1, D, b.velocity.begin());
        std::copy_n(v + 2 * D + 1, spins<D>, b.spin.begin());
        return b;
    });
    auto displaced = take_rows<2 + freedoms, Displaced>(kept, "bodies/displaced", id.size(), [](double const* v) {
        Displaced d{.mass = v[0], .gyration = v[1], .motion = {}};
        std::copy_n(v + 2, freedoms, d.motion.begin());
        return d;
    });
    auto past = take_rows<freedoms, Past>(kept, "last/velocity", last_id.size(), [](double const* v) {
        Past p{};
        std::copy_n(v, freedoms, p.motion.begin());
        return p;
    });
    auto const exchange = kept.numbers("last/exchange", freedoms * last_id.size());
    for (std::size_t i = 0; i < past.size(); ++i)
        std::copy_n(exchange.data() + freedoms * i, freedoms, past[i].exchange.begin());
    for (Body<D> const& b : bodies)
        sluice::require(std::isfinite(std::accumulate(b.centre.begin(), b.centre.end(), b.radius)) && b.radius > 0, [] {
            return sluice::Error(
                "fluid: the checkpoint has a body without a place (needs numbers, radius > 0). Resume "
                "from an older one.",
                sluice::Exit::io);
        });
    std::vector<Motion> solids;
    if (!solid_exchange_.empty())
        solids = take_rows<freedoms, Motion>(kept, "solids/exchange", solid_exchange_.size(), [](double const* v) {
            Motion m;
            std::copy_n(v, freedoms, m.begin());
            return m;
        });
    std::array<double const*, Lattice<D>::directions> from;
    for (std::size_t q = 0; q < from.size(); ++q) from[q] = kept.numbers(populations_name(q), cells).data();
    if (phase_) phase_->restore(kept);

    steps_ = kept.integer("steps");
    find_field();
    id_ = std::move(id);
    last_id_ = std::move(last_id);
    bodies_ = std::move(bodies);
    displaced_ = std::move(displaced);
    past_ = std::move(past);
    solid_exchange_ = std::move(solids);
    resize_loads(id_.size());
    for (std::size_t q = 0; q < from.size(); ++q)
        for (std::ptrdiff_t r = 0; r < populations_.rows(); ++r, from[q] += populations_.nx())
            std::copy(from[q], from[q] + populations_.nx(), populations_.row(q, r));
    for (std::ptrdiff_t r = 0; r < populations_.rows(); ++r) note_turned(populations_, r, walls_);
    coverage_.update(bodies_, team_);
    if (phase_) phase_->spread();
    complete_ = true;
}

template void Solver<2>::keep(sluice::State&);
template void Solver<3>::keep(sluice::State&);
template void Solver<2>::restore(sluice::State const&);
template void Solver<3>::restore(sluice::State const&);

}  // namespace lbm
