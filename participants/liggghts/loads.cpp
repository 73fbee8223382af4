#include "participants/liggghts/loads.hpp"

#include <algorithm>
#include <cassert>

namespace liggghts {

void Loads::reset(std::span<int const> tags)
{
    set_tags(tags);
    std::ranges::fill(force, 0.0);
    std::ranges::fill(torque, 0.0);
}

void Loads::set_tags(std::span<int const> tags)
{
    if (!std::ranges::equal(tags, tags_)) {
        tags_.assign(tags.begin(), tags.end());
        rows_.clear();
        where_.clear();
    }
    force.resize(3 * tags_.size());
    torque.resize(3 * tags_.size());
}

void Loads::set(std::span<int const> tags, std::span<double const> forces, std::span<double const> torques)
{
    set_tags(tags);
    assert(forces.size() == force.size() && torques.size() == torque.size());
    std::ranges::copy(forces, force.begin());
    std::ranges::copy(torques, torque.begin());
}

void Loads::set_mean(Loads const& a, Loads const& b)
{
    assert(a.tags_ == b.tags_);
    set_tags(a.tags_);
    for (std::size_t k = 0; k < force.size(); ++k) force[k] = 0.5 * (a.force[k] + b.force[k]);
    for (std::size_t k = 0; k < torque.size(); ++k) torque[k] = 0.5 * (a.torque[k] + b.torque[k]);
}

std::vector<std::uint32_t> Loads::by_tag() const
{
    int const largest = tags_.empty() ? 0 : *std::ranges::max_element(tags_);
    std::vector<std::uint32_t> found(static_cast<std::size_t>(largest) + 1, nobody);
    for (std::size_t n = 0; n < tags_.size(); ++n)
        found[static_cast<std::size_t>(tags_[n])] = static_cast<std::uint32_t>(n);
    return found;
}

bool Loads::fits(Rows const& rows) const
{
    return std::equal(tags_.begin(), tags_.end(), rows.tag, rows.tag + rows.count);
}

template <class Each>
void Loads::each_row(Rows const& rows, Each&& each)
{
    auto const count = static_cast<std::size_t>(rows.count);
    if (fits(rows)) {
        for (std::size_t i = 0; i < count; ++i) each(i, i);
        return;
    }
    if (!std::equal(rows_.begin(), rows_.end(), rows.tag, rows.tag + count)) {
        auto const found = by_tag();
        rows_.assign(rows.tag, rows.tag + count);
        where_.assign(count, nobody);
        for (std::size_t i = 0; i < count; ++i)
            if (auto const tag = static_cast<std::size_t>(rows_[i]); tag < found.size()) where_[i] = found[tag];
    }
    for (std::size_t i = 0; i < count; ++i)
        if (where_[i] != nobody) each(i, where_[i]);
}

void Loads::add_to(Rows const& rows)
{
    if (rows.count == 0) return;
    double *f = rows.force[0], *t = rows.torque[0];  // LIGGGHTS has its rows one behind the other
    if (fits(rows)) {
        for (std::size_t k = 0; k < force.size(); ++k) f[k] += force[k];
        for (std::size_t k = 0; k < torque.size(); ++k) t[k] += torque[k];
        return;
    }
    each_row(rows, [&](std::size_t row, std::size_t n) {
        for (std::size_t k = 0; k < 3; ++k) f[3 * row + k] += force[3 * n + k];
        for (std::size_t k = 0; k < 3; ++k) t[3 * row + k] += torque[3 * n + k];
    });
}

void Loads::replace(Rows const& rows, Loads& before)
{
    if (before.tags_ == tags_) {  // their change in one pass
        for (std::size_t k = 0; k < force.size(); ++k) before.force[k] = force[k] - before.force[k];
        for (std::size_t k = 0; k < torque.size(); ++k) before.torque[k] = torque[k] - before.torque[k];
        return before.add_to(rows);
    }
    for (auto* numbers : {&before.force, &before.torque})
        for (double& number : *numbers) number = -number;
    before.add_to(rows);
    add_to(rows);
}

double Loads::power(Rows const& rows)
{
    double power = 0.0;
    each_row(rows, [&](std::size_t row, std::size_t n) {
        double const *v = rows.velocity[row], *w = rows.spin[row];
        for (std::size_t k = 0; k < 3; ++k) power += force[3 * n + k] * v[k] + torque[3 * n + k] * w[k];
    });
    return power;
}

}  // namespace liggghts
