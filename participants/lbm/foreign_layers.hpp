#pragma once

#include <algorithm>
#include <array>
#include <map>
#include <utility>
#include <vector>

#include "participants/lbm/domain.hpp"
#include "participants/lbm/fields.hpp"

namespace lbm {

//! Calls visit(r) for the rows of one layer across the last axis, in one order.
template <int D, class Visit>
void each_row_of_layer(Layout const& layout, std::ptrdiff_t layer, Visit&& visit)
{
    std::ptrdiff_t const z = D == 2 ? 0 : layer, first = D == 2 ? layer : 0,
                         last = D == 2 ? layer + 1 : layout.cells()[1];
    for (std::ptrdiff_t y = first; y < last; ++y)
        for (std::uint32_t const r : layout.across(y, z)) visit(static_cast<std::ptrdiff_t>(r));
}

//! Begin and end of the blocks of k layers whose first layer a process has.
template <int D>
std::array<std::ptrdiff_t, 2> blocks_of(Domain<D> const& domain, int rank, std::ptrdiff_t k)
{
    return {(domain.slabs().begin(rank) + k - 1) / k, (domain.slabs().end(rank) + k - 1) / k};
}

//! Layers of other processes that a picture in blocks of k layers needs here: of our blocks, and those beside them.
template <int D>
class ForeignLayers
{
 public:
    //! `read(r, row)`: the state of one of our rows. All processes together.
    template <class Read>
    ForeignLayers(Domain<D> const& domain, bool periodic, std::ptrdiff_t k, Read&& read)
    {
        auto* const peers = domain.peers();
        if (!peers) return;
        std::vector<ranks::Bytes> out;
        for (int p = 0; p < peers->count(); ++p) {
            std::vector<double> numbers;
            for (std::ptrdiff_t const layer : needed(domain, p, periodic, k))
                if (domain.has_layers(layer, layer + 1)) append(domain.own(), layer, read, numbers);
            out.push_back(ranks::to_bytes(numbers));
        }
        auto const in = peers->all_to_all(std::move(out));
        std::vector<std::vector<double>> came;
        for (auto const& bytes : in) came.push_back(ranks::rows_of<double>(bytes));
        std::vector<std::size_t> at(came.size());
        for (std::ptrdiff_t const layer : needed(domain, peers->rank(), periodic, k)) {
            std::size_t numbers = 0;
            each_row_of_layer<D>(domain.whole(), layer, [&](std::ptrdiff_t r) {
                numbers += columns * static_cast<std::size_t>(domain.whole().row(r).cells);
            });
            auto const owner = static_cast<std::size_t>(domain.slabs().owner(layer));
            auto const begin = came[owner].begin() + static_cast<std::ptrdiff_t>(at[owner]);
            layers_[layer] = {{begin, begin + static_cast<std::ptrdiff_t>(numbers)}, 0};
            at[owner] += numbers;
        }
    }

    bool has(std::ptrdiff_t layer) const { return layers_.contains(layer); }
    //! The next row of a layer, that has so many cells; after the last one the first.
    void take(std::ptrdiff_t layer, std::ptrdiff_t cells, RowState<D>& row)
    {
        auto& [numbers, next] = layers_.at(layer);
        each_column(row, [&](std::vector<double>& column) {
            auto const begin = numbers.begin() + static_cast<std::ptrdiff_t>(next);
            column.assign(begin, begin + cells);
            next += static_cast<std::size_t>(cells);
        });
        if (next == numbers.size()) next = 0;
    }

 private:
    static constexpr std::size_t columns = 2 + D;

    template <class Visit>
    static void each_column(RowState<D>& row, Visit&& visit)
    {
        visit(row.excess);
        visit(row.fraction);
        for (auto& component : row.velocity) visit(component);
    }
    //! Layers that a process needs and has not.
    static std::vector<std::ptrdiff_t> needed(Domain<D> const& domain, int rank, bool periodic, std::ptrdiff_t k)
    {
        auto const [first, last] = blocks_of(domain, rank, k);
        if (first == last) return {};
        return domain.missing_layers(rank, first * k - 1, std::min(last * k, domain.whole().cells()[D - 1]) + 1,
                                     periodic);
    }
    template <class Read>
    static void append(Layout const& own, std::ptrdiff_t layer, Read&& read, std::vector<double>& numbers)
    {
        RowState<D> row;
        each_row_of_layer<D>(own, layer, [&](std::ptrdiff_t r) {
            read(r, row);
            each_column(row, [&](std::vector<double> const& column) {
                numbers.insert(numbers.end(), column.begin(), column.end());
            });
        });
    }

    struct Layer
    {
        std::vector<double> numbers;
        std::size_t next;
    };
    std::map<std::ptrdiff_t, Layer> layers_;
};

}  // namespace lbm
