#include "participants/dem/partner_loads.hpp"

#include <algorithm>
#include <string>

#include "coupler/base/error.hpp"

namespace dem {

Finder::Finder(std::vector<std::int64_t> const& id) : count_(id.size())
{
    if (id.empty()) return;
    auto const [least, most] = std::minmax_element(id.begin(), id.end());
    lowest_ = *least;
    if (static_cast<std::uint64_t>(*most - lowest_) < 8 * count_ + 1024)
        table_.assign(static_cast<std::size_t>(*most - lowest_) + 1, count_);
    for (std::size_t i = 0; i < count_; ++i)
        if (table_.empty())
            index_.emplace(id[i], i);
        else
            table_[static_cast<std::size_t>(id[i] - lowest_)] = i;
}

std::size_t Finder::operator()(std::int64_t id) const
{
    std::size_t const found = look_up(id);
    sluice::require(found < count_, [&] {
        return sluice::Error(
            "a load on grain " + std::to_string(id) + ", which is none of the " + std::to_string(count_) + " grains.",
            sluice::Exit::protocol);
    });
    return found;
}

std::size_t Finder::look_up(std::int64_t id) const
{
    if (table_.empty()) {
        auto const found = index_.find(id);
        return found == index_.end() ? count_ : found->second;
    }
    if (id < lowest_ || static_cast<std::uint64_t>(id - lowest_) >= table_.size()) return count_;
    return table_[static_cast<std::size_t>(id - lowest_)];
}

template <int D>
void PartnerLoads<D>::take(std::vector<PartnerLoad> const& parts)
{
    std::fill(sum_.begin(), sum_.end(), Load<D>{});
    for (PartnerLoad const& part : parts) add(part);
    force_ = {};
    for (Load<D> const& load : sum_) force_ += load.force;
}

template <int D>
void PartnerLoads<D>::add(PartnerLoad const& load)
{
    for (std::size_t k = 0; k < load.id.size(); ++k) {
        Load<D>& to = sum_[find_(load.id[k])];
        if constexpr (D == 2) {
            to.force += Vec2{load.force[2 * k], load.force[2 * k + 1]};
            if (!load.torque.empty()) to.torque += load.torque[k];
        } else {
            to.force += Vec3{load.force[3 * k], load.force[3 * k + 1], load.force[3 * k + 2]};
            if (!load.torque.empty())
                to.torque += Vec3{load.torque[3 * k], load.torque[3 * k + 1], load.torque[3 * k + 2]};
        }
    }
}

template class PartnerLoads<2>;
template class PartnerLoads<3>;

}  // namespace dem
