#include "participants/liggghts/told.hpp"

#include <algorithm>

namespace liggghts {

template <int D>
void Told<D>::update(Rows const& rows)
{
    rows_ = rows;
    auto const count = static_cast<std::size_t>(rows.count);
    if (!std::equal(tags_.begin(), tags_.end(), rows.tag, rows.tag + count)) {
        tags_.assign(rows.tag, rows.tag + count);
        id_.clear();
        for (int const tag : tags_) id_.push_back(ids_->empty() ? tag : ids_->at(static_cast<std::size_t>(tag) - 1));
    }
    if constexpr (D == 2) {
        position_.resize(2 * count);
        velocity_.resize(2 * count);
        spin_.resize(count);
        for (std::size_t i = 0; i < count; ++i) {
            std::copy_n(rows.place[i], 2, &position_[2 * i]);
            std::copy_n(rows.velocity[i], 2, &velocity_[2 * i]);
            spin_[i] = rows.spin[i][2];
        }
    }
}

template class Told<2>;
template class Told<3>;

}  // namespace liggghts
