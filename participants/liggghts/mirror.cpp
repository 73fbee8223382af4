#include "participants/liggghts/mirror.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

namespace liggghts {

template <int D>
Mirror<D>::Mirror(std::vector<std::int64_t> const& ids, std::vector<int> tags) : ids_(&ids), tags_(std::move(tags))
{
    position_.resize(D * tags_.size());
    velocity_.resize(D * tags_.size());
    spin_.resize((D == 2 ? 1 : 3) * tags_.size());
    radius_.resize(tags_.size());
    mass_.resize(tags_.size());
}

template <int D>
Mirror<D>::Mirror(std::vector<std::int64_t> const& ids, Rows const& rows)
    : Mirror(ids, std::vector<int>(rows.tag, rows.tag + rows.count))
{
    std::vector<std::size_t> row(tags_.size());
    std::iota(row.begin(), row.end(), std::size_t{0});
    std::ranges::sort(row, {}, [&](std::size_t i) { return rows.tag[i]; });
    for (std::size_t at = 0; at < row.size(); ++at) {
        std::size_t const i = row[at];
        tags_[at] = rows.tag[i];
        std::copy_n(rows.place[i], D, &position_[D * at]);
        std::copy_n(rows.velocity[i], D, &velocity_[D * at]);
        if constexpr (D == 2)
            spin_[at] = rows.spin[i][2];
        else
            std::copy_n(rows.spin[i], 3, &spin_[3 * at]);
        radius_[at] = rows.radius[i];
        mass_[at] = rows.mass[i];
    }
}

template <int D>
Mirror<D> Mirror<D>::whole(std::size_t largest, Sum const& sum) const
{
    //! Of all tags, whether they are in use or not.
    auto const of_all = [&](std::vector<double> const& own, std::size_t width) {
        std::vector<double> dense(width * (largest + 1), 0.0);
        for (std::size_t i = 0; i < tags_.size(); ++i)
            std::copy_n(&own[width * i], width, &dense[width * static_cast<std::size_t>(tags_[i])]);
        sum(dense.data(), dense.size());
        return dense;
    };
    std::vector<double> const there = of_all(std::vector<double>(tags_.size(), 1.0), 1);
    std::vector<int> tags;
    for (std::size_t tag = 0; tag <= largest; ++tag)
        if (there[tag] > 0.0) tags.push_back(static_cast<int>(tag));
    Mirror all(*ids_, std::move(tags));
    for (auto const column :
         {&Mirror::position_, &Mirror::velocity_, &Mirror::spin_, &Mirror::radius_, &Mirror::mass_}) {
        auto& to = all.*column;
        std::size_t const width = to.size() / std::max<std::size_t>(all.tags_.size(), 1);
        auto const dense = of_all(this->*column, width);
        for (std::size_t i = 0; i < all.tags_.size(); ++i)
            std::copy_n(&dense[width * static_cast<std::size_t>(all.tags_[i])], width, &to[width * i]);
    }
    return all;
}

template <int D>
dem::Grains<D> Mirror<D>::grains() const
{
    dem::Grains<D> g;
    for (std::size_t i = 0; i < tags_.size(); ++i) {
        double const *x = &position_[D * i], *v = &velocity_[D * i];
        dem::Motion<D> motion{};
        dem::Vec<D> centre{};
        if constexpr (D == 2) {
            centre = {x[0], x[1]};
            motion.velocity = {v[0], v[1]};
            motion.spin = spin_[i];
        } else {
            centre = {x[0], x[1], x[2]};
            motion.velocity = {v[0], v[1], v[2]};
            motion.spin = {spin_[3 * i], spin_[3 * i + 1], spin_[3 * i + 2]};
        }
        g.add(centre, radius_[i], mass_[i] / dem::volume_of<D>(radius_[i]), motion);
        g.id[i] = ids_->empty() ? tags_[i] : ids_->at(static_cast<std::size_t>(tags_[i]) - 1);
        g.mass[i] = mass_[i];
    }
    return g;
}

template class Mirror<2>;
template class Mirror<3>;

}  // namespace liggghts
