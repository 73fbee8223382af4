// Solver: all that it needs to go on bit for bit, as named arrays.
#include <algorithm>
#include <cmath>
#include <cstring>
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

template <int D, class Stored>
void put_populations(sluice::State& kept, Rows<D, Stored> const& rows)
{
    std::vector<Stored> cells;
    cells.reserve(static_cast<std::size_t>(rows.layout().stored()));
    for (std::size_t q = 0; q < Lattice<D>::directions; ++q) {
        cells.clear();
        for (std::ptrdiff_t r = 0; r < rows.rows(); ++r)
            cells.insert(cells.end(), rows.row(q, r), rows.row(q, r) + rows.nx(r));
        std::span<Stored const> const values(cells);
        if constexpr (std::is_same_v<Stored, double>)
            kept.put(populations_name(q), values);
        else
            kept.put(populations_name(q), std::as_bytes(values));
    }
}

//! Throws Error (exit 7) unless they are there, as many as wanted.
void require_populations(sluice::State const& kept, std::size_t q, std::size_t cells, Precision precision)
{
    if (precision == Precision::float64) {
        kept.numbers(populations_name(q), cells);
        return;
    }
    std::size_t const bytes = kept.bytes(populations_name(q)).size(), needed = cells * bytes_of(precision);
    sluice::require(bytes == needed, [&] {
        return sluice::Error("state: \"" + populations_name(q) + "\" has " + std::to_string(bytes) + " bytes (needs " +
                                 std::to_string(needed) + "). Was it made with another lattice?",
                             sluice::Exit::io);
    });
}

template <int D, class Stored>
void take_populations(sluice::State const& kept, Rows<D, Stored> const& rows)
{
    for (std::size_t q = 0; q < Lattice<D>::directions; ++q) {
        auto const name = populations_name(q);
        std::span<std::byte const> from;
        if constexpr (std::is_same_v<Stored, double>)
            from = std::as_bytes(kept.numbers(name));
        else
            from = kept.bytes(name);
        for (std::ptrdiff_t r = 0; r < rows.rows(); ++r) {
            auto const bytes = static_cast<std::size_t>(rows.nx(r)) * sizeof(Stored);
            std::memcpy(rows.row(q, r), from.data(), bytes);
            from = from.subspan(bytes);
        }
    }
}

//! Boundary::incoming of one side after the other.
std::vector<double> incoming_of(Walls const& walls)
{
    std::vector<double> all;
    for (auto const& pair : walls.side)
        for (Boundary const& side : pair) all.insert(all.end(), side.incoming.begin(), side.incoming.end());
    return all;
}

std::vector<std::int64_t> numbers_of(std::vector<Box> const& boxes)
{
    std::vector<std::int64_t> numbers;
    for (Box const& box : boxes)
        for (Extent const* e : {&box.first, &box.size}) numbers.insert(numbers.end(), e->begin(), e->end());
    return numbers;
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
    if (config_.lightest_grain > 0) put_rows<freedoms>(kept, "last/load", past_, [](Past const& p) { return p.load; });
    if (phase_) phase_->keep(kept);
    if (!solid_exchange_.empty())
        put_rows<freedoms>(kept, "solids/exchange", solid_exchange_, [](Motion const& m) { return m; });
    if (!layout_.whole()) {
        auto const boxes = numbers_of(layout_.boxes());
        kept.put("boxes", std::span<std::int64_t const>(boxes));
    }
    if (!extra_.empty()) kept.put("layers/extra", std::span<double const>(extra_));
    if (links_) {
        auto missing = links_->missing();
        missing.resize(id_.size());  // before the first step
        kept.put("bodies/missing", std::span<double const>(missing));
    }
    if (auto const incoming = incoming_of(walls_); !incoming.empty())
        kept.put("sides/incoming", std::span<double const>(incoming));
    populations_.visit([&](auto const& rows) { put_populations(kept, rows); });
}

std::vector<double> extra_of(sluice::State const& kept)
{
    if (!kept.has("layers/extra")) return {};
    auto const extra = kept.numbers("layers/extra");
    return {extra.begin(), extra.end()};
}

//! Everything is taken out before anything changes: what does not fit leaves the solver as it was.
template <int D>
void Solver<D>::restore(sluice::State const& kept)
{
    constexpr std::size_t place = 2 * D + 1 + spins<D>;
    auto const cells = static_cast<std::size_t>(layout_.stored());
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
    auto const load =
        config_.lightest_grain > 0 ? kept.numbers("last/load", freedoms * last_id.size()) : std::span<double const>();
    for (std::size_t i = 0; i < past.size() && !load.empty(); ++i)
        std::copy_n(load.data() + freedoms * i, freedoms, past[i].load.begin());
    for (Body<D> const& b : bodies)
        sluice::require(std::isfinite(std::accumulate(b.centre.begin(), b.centre.end(), b.radius)) && b.radius > 0, [] {
            return sluice::Error(
                "fluid: the checkpoint has a body without a place (needs numbers, radius > 0). Resume "
                "from an older one.",
                sluice::Exit::io);
        });
    std::vector<Motion> solids;
    if (kept.has("solids/exchange"))
        solids = take_rows<freedoms, Motion>(kept, "solids/exchange", coverage_.patches().size(), [](double const* v) {
            Motion m;
            std::copy_n(v, freedoms, m.begin());
            return m;
        });
    sluice::require(std::ranges::equal(extra_of(kept), extra_), [] {
        return sluice::Error("fluid: the checkpoint's lattice is shared out otherwise (needs the same cost of layers).",
                             sluice::Exit::io);
    });
    if (!layout_.whole())
        sluice::require(std::ranges::equal(kept.integers("boxes"), numbers_of(layout_.boxes())), [] {
            return sluice::Error(
                "fluid: the checkpoint holds other parts of the lattice (needs those that hold fluid now). Were the "
                "solids moved since?",
                sluice::Exit::io);
        });
    for (std::size_t q = 0; q < Lattice<D>::directions; ++q) require_populations(kept, q, cells, config_.precision);
    auto const missing = links_ ? kept.numbers("bodies/missing", id.size()) : std::span<double const>();
    std::size_t const beside = incoming_of(walls_).size();
    auto const incoming = beside > 0 ? kept.numbers("sides/incoming", beside) : std::span<double const>();
    if (phase_) phase_->restore(kept);

    auto next = incoming.begin();
    for (auto& pair : walls_.side)
        for (Boundary& side : pair)
            for (double& cell : side.incoming) cell = *next++;
    if (halo_) halo_->receive(populations_);  // lest they come later
    steps_ = kept.integer("steps");
    find_field();
    id_ = std::move(id);
    last_id_ = std::move(last_id);
    bodies_ = std::move(bodies);
    displaced_ = std::move(displaced);
    past_ = std::move(past);
    solid_exchange_ = std::move(solids);
    resize_loads(id_.size());
    coverage_.update(covering(), team_);
    for (auto& pair : walls_.side)
        for (Boundary& side : pair) std::ranges::fill(side.held, Boundary::Held{});
    if (steps_ > 0) note_held();  // before the first step nothing has held fluid
    populations_.visit([&](auto const& rows) {
        take_populations(kept, rows);
        for (std::ptrdiff_t r = 0; r < rows.rows(); ++r) note_turned(rows, r, walls_, Incoming::kept);
    });
    if (links_) links_->restore(bodies_, id_, walls_.half_force, missing);
    if (phase_) phase_->spread();
    complete_ = true;
}

template void Solver<2>::keep(sluice::State&);
template void Solver<3>::keep(sluice::State&);
template void Solver<2>::restore(sluice::State const&);
template void Solver<3>::restore(sluice::State const&);

}  // namespace lbm
