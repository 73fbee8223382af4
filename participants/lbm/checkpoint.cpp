// Solver: all that it needs to go on bit for bit, as named arrays.
#include <algorithm>
#include <cmath>
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

void Solver::keep(sluice::State& kept)
{
    complete();
    kept.put_integer("steps", steps_);
    put_ids(kept, "discs/id", id_);
    put_rows<6>(kept, "discs/place", discs_,
                [](Disc const& d) { return std::array{d.x, d.y, d.radius, d.ux, d.uy, d.spin}; });
    put_rows<5>(kept, "discs/displaced", displaced_, [](Displaced const& d) {
        return std::array{d.mass, d.gyration, d.velocity[0], d.velocity[1], d.velocity[2]};
    });
    put_ids(kept, "last/id", last_id_);
    put_rows<3>(kept, "last/velocity", past_, [](Past const& p) { return p.velocity; });
    put_rows<3>(kept, "last/exchange", past_, [](Past const& p) { return p.exchange; });
    std::vector<double> cells;
    cells.reserve(static_cast<std::size_t>(populations_.nx() * populations_.ny()));
    for (std::size_t q = 0; q < directions; ++q) {
        cells.clear();
        for (std::ptrdiff_t y = 0; y < populations_.ny(); ++y)
            cells.insert(cells.end(), populations_.row(q, y), populations_.row(q, y) + populations_.nx());
        kept.put(populations_name(q), std::span<double const>(cells));
    }
}

//! Everything is taken out before anything changes: what does not fit leaves the solver as it was.
void Solver::restore(sluice::State const& kept)
{
    auto const cells = static_cast<std::size_t>(populations_.nx() * populations_.ny());
    auto id = take_ids(kept, "discs/id"), last_id = take_ids(kept, "last/id");
    auto discs = take_rows<6, Disc>(kept, "discs/place", id.size(), [](double const* v) {
        return Disc{.x = v[0], .y = v[1], .radius = v[2], .ux = v[3], .uy = v[4], .spin = v[5]};
    });
    auto displaced = take_rows<5, Displaced>(kept, "discs/displaced", id.size(), [](double const* v) {
        return Displaced{.mass = v[0], .gyration = v[1], .velocity = {v[2], v[3], v[4]}};
    });
    auto past = take_rows<3, Past>(kept, "last/velocity", last_id.size(), [](double const* v) {
        return Past{{v[0], v[1], v[2]}, {}};
    });
    auto const exchange = kept.numbers("last/exchange", 3 * last_id.size());
    for (std::size_t i = 0; i < past.size(); ++i) std::copy_n(exchange.data() + 3 * i, 3, past[i].exchange.begin());
    for (Disc const& d : discs)
        sluice::require(std::isfinite(d.x + d.y + d.radius) && d.radius > 0, [] {
            return sluice::Error(
                "fluid: the checkpoint has a disc without a place (needs numbers, radius > 0). Resume "
                "from an older one.",
                sluice::Exit::io);
        });
    std::array<double const*, directions> from;
    for (std::size_t q = 0; q < directions; ++q) from[q] = kept.numbers(populations_name(q), cells).data();

    steps_ = kept.integer("steps");
    id_ = std::move(id);
    last_id_ = std::move(last_id);
    discs_ = std::move(discs);
    displaced_ = std::move(displaced);
    past_ = std::move(past);
    resize_loads(id_.size());
    for (std::size_t q = 0; q < directions; ++q)
        for (std::ptrdiff_t y = 0; y < populations_.ny(); ++y, from[q] += populations_.nx())
            std::copy(from[q], from[q] + populations_.nx(), populations_.row(q, y));
    coverage_.update(discs_, team_);
    complete_ = true;
}

}  // namespace lbm
