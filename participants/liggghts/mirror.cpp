#include "participants/liggghts/mirror.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace liggghts {
namespace {

constexpr auto nobody = std::numeric_limits<std::uint32_t>::max();

template <int D>
void take(Rows const& rows, int i, dem::Grains<D>& g, std::size_t at)
{
    double const *x = rows.place[i], *v = rows.velocity[i], *w = rows.spin[i];
    if constexpr (D == 2) {
        g.place[at].centre = {x[0], x[1]};
        g.motion[at].velocity = {v[0], v[1]};
        g.motion[at].spin = w[2];
    } else {
        g.place[at].centre = {x[0], x[1], x[2]};
        g.motion[at].velocity = {v[0], v[1], v[2]};
        g.motion[at].spin = {w[0], w[1], w[2]};
    }
    double const r = rows.radius[i], m = rows.mass[i];
    g.place[at].radius = r;
    g.mass[at] = m;
    g.inertia[at] = (D == 2 ? 0.5 : 0.4) * m * r * r;
}

}  // namespace

template <int D>
bool Mirror<D>::knows(Rows const& rows) const
{
    if (static_cast<std::size_t>(rows.count) != tags_.size()) return false;
    return std::all_of(rows.tag, rows.tag + rows.count, [&](int tag) {
        return static_cast<std::size_t>(tag) < index_.size() && index_[static_cast<std::size_t>(tag)] != nobody;
    });
}

template <int D>
void Mirror<D>::learn(Rows const& rows)
{
    tags_.assign(rows.tag, rows.tag + rows.count);
    std::sort(tags_.begin(), tags_.end());
    index_.assign(tags_.empty() ? 0 : static_cast<std::size_t>(tags_.back()) + 1, nobody);
    grains_ = {};
    for (std::size_t k = 0; k < tags_.size(); ++k) {
        auto const tag = static_cast<std::size_t>(tags_[k]);
        index_[tag] = static_cast<std::uint32_t>(k);
        grains_.add({}, 0.0, 0.0);
        grains_.id[k] = ids_.empty() ? tags_[k] : ids_.at(tag - 1);
    }
}

template <int D>
void Mirror<D>::update(Rows const& rows)
{
    if (!knows(rows)) learn(rows);
    for (int i = 0; i < rows.count; ++i) take(rows, i, grains_, index_[static_cast<std::size_t>(rows.tag[i])]);
}

template class Mirror<2>;
template class Mirror<3>;

}  // namespace liggghts
