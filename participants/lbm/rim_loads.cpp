#include "participants/lbm/rim_loads.hpp"

#include <algorithm>

#include "participants/lbm/lanes.hpp"

namespace lbm {
namespace {

//! Twice the sum of numbers that are so far apart, and of each times its index.
template <std::ptrdiff_t apart, class Stored>
[[gnu::always_inline]] inline std::array<double, 2> twice_the_sum(Stored const* numbers, std::ptrdiff_t count)
{
    using V = Lanes<double>;
    constexpr auto lanes = static_cast<std::ptrdiff_t>(V::count);
    if (count == 1) return {2.0 * numbers[0], 0.0};
    std::array<double, 2> total{};
    std::ptrdiff_t k = 0;
    if (count >= lanes) {
        V sum, moment, index = counted_from<V>(0);
        for (; k + lanes <= count; k += lanes) {
            V f;
            if constexpr (apart == 1)
                f = load<V>(numbers + k);
            else
                for (std::ptrdiff_t i = 0; i < lanes; ++i) f.all[i] = numbers[(k + i) * apart];
            sum = sum + f;
            moment = madd(index, f, moment);
            index = index + static_cast<double>(lanes);
        }
        total = {sum_of(sum), sum_of(moment)};
    }
    for (; k < count; ++k) total[0] += numbers[k * apart], total[1] += static_cast<double>(k) * numbers[k * apart];
    return {2 * total[0], 2 * total[1]};
}

}  // namespace

//! Of a rim, link by link.
template <int D>
class RimLoads<D>::Sum
{
 public:
    explicit Sum(Rim const& rim) : rim_(rim) {}

    template <class Stored>
    void add_row(Link const& link, Stored const* numbers)
    {
        auto const [sum, moment] = twice_the_sum<1>(numbers, link.cells);
        add(link, sum, moment, 0);
    }
    template <class Stored>
    void add_ends(Link const& link, Stored const* numbers)
    {
        auto const [sum, moment] = twice_the_sum<along_x<D>>(numbers, rim_.rows);
        add(link, sum, 0, moment);
    }
    Load load() const
    {
        auto torque = cross(rim_.arm, force_);
        torque[0] += along_[1][2];
        torque[1] -= along_[0][2];
        torque[2] += along_[0][1] - along_[1][0];
        Load load;
        std::copy_n(force_.begin(), D, load.begin());
        std::copy_n(torque.end() - spins<D>, spins<D>, load.begin() + D);
        return load;
    }

 private:
    void add(Link const& link, double sum, double x_moment, double y_moment)
    {
        for (std::size_t k = 0; k < D; ++k) {
            double const c = Lattice<D>::c[link.direction][k];
            force_[k] += c * sum;
            along_[0][k] += c * (x_moment + link.x * sum);
            along_[1][k] += c * y_moment;
        }
    }

    Rim const& rim_;
    std::array<double, 3> force_{};
    std::array<std::array<double, 3>, 2> along_{};  //!< of each cell its x, and its y from the first row, times force
};

template <int D>
RimLoads<D>::RimLoads(Domain<D> const& domain, Entrances const& entrances, Patches const& patches)
    : domain_(domain), patches_(patches.size())
{
    std::vector<std::ptrdiff_t> last_ends(patches_, -1);  // in rims_
    for (std::ptrdiff_t r = 0; r < domain.own().rows(); ++r) {
        start_.push_back(static_cast<std::uint32_t>(rims_.size()));
        for (Rim& rim : rims_of_row(r, entrances.of_row(r), patches)) {
            std::ptrdiff_t& last = last_ends[static_cast<std::size_t>(rim.patch)];
            if (rim.ends && last >= 0 && is_next(rim, rims_[static_cast<std::size_t>(last)])) {
                ++rims_[static_cast<std::size_t>(last)].rows;
                continue;
            }
            if (rim.ends) last = static_cast<std::ptrdiff_t>(rims_.size());
            rims_.push_back(std::move(rim));
        }
    }
    start_.push_back(static_cast<std::uint32_t>(rims_.size()));
}

//! For each patch that a row gives to one of its ends, and one of what leaves it elsewhere.
template <int D>
std::vector<typename RimLoads<D>::Rim> RimLoads<D>::rims_of_row(std::ptrdiff_t r, std::vector<Entrance> const& links,
                                                                Patches const& patches) const
{
    Row const& row = domain_.own().row(r);
    std::vector<Rim> rims;
    for (Entrance const& link : links) {
        if (link.patch < 0) continue;
        int const along = Lattice<D>::c[link.from][0];
        bool const ends = link.cells == 1 && along != 0 && link.x == (along > 0 ? row.cells - 1 : 0);
        auto rim = std::ranges::find_if(
            rims, [&](Rim const& other) { return other.patch == link.patch && other.ends == ends; });
        if (rim == rims.end()) {
            std::array<double, 3> arm{row.first + 0.5, row.y + 0.5, row.z + 0.5};
            for (std::size_t k = 0; k < D; ++k) arm[k] -= patches[static_cast<std::size_t>(link.patch)].centre[k];
            rim = rims.insert(rims.end(), Rim{link.patch, ends, r, 1, {}, arm});
        }
        rim->links.push_back({link.from, link.x, link.cells});
    }
    return rims;
}

//! Whether rims of ends are of rows that follow one another, and are alike.
template <int D>
bool RimLoads<D>::is_next(Rim const& rim, Rim const& last) const
{
    Layout const& layout = domain_.own();
    return last.row + last.rows == rim.row && last.links == rim.links &&
           layout.row(last.row).box == layout.row(rim.row).box &&
           domain_.layer_of(last.row) == domain_.layer_of(rim.row);
}

template <int D>
void RimLoads<D>::find(Populations<D> const& populations, std::ptrdiff_t begin, std::ptrdiff_t end)
{
    if (rims_.empty()) return;
    for (std::size_t k = start_[static_cast<std::size_t>(begin)]; k < start_[static_cast<std::size_t>(end)]; ++k) {
        Rim& rim = rims_[k];
        if (rim.ends) continue;
        Sum sum(rim);
        populations.visit([&](auto const& rows) {
            for (Link const& link : rim.links) sum.add_row(link, rows.row(link.direction, rim.row) + link.x);
        });
        rim.load = sum.load();
    }
}

template <int D>
void RimLoads<D>::add_parts(Populations<D> const& populations, std::size_t first,
                            std::vector<SumPart<D + spins<D>>>& parts) const
{
    constexpr std::int64_t none = -1;
    std::vector<SumPart<D + spins<D>>> now;  // of each patch
    for (std::size_t i = 0; i < patches_; ++i) now.push_back({first + i, none, {}});
    for (Rim const& rim : rims_) {
        Load load = rim.load;
        if (rim.ends) {
            Sum sum(rim);
            populations.visit([&](auto const& rows) {
                for (Link const& link : rim.links) sum.add_ends(link, rows.end(link.direction, rim.row));
            });
            load = sum.load();
        }
        auto& part = now[static_cast<std::size_t>(rim.patch)];
        if (part.layer != domain_.layer_of(rim.row)) {
            if (part.layer != none) parts.push_back(part);
            part = {part.which, domain_.layer_of(rim.row), {}};
        }
        for (std::size_t f = 0; f < load.size(); ++f) part.sum[f] += load[f];
    }
    for (auto const& part : now)
        if (part.layer != none) parts.push_back(part);
}

template class RimLoads<2>;
template class RimLoads<3>;

}  // namespace lbm
