#include "participants/dem/checkpoint.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <utility>

#include "coupler/base/error.hpp"
#include "participants/dem/bytes.hpp"

namespace dem {
namespace {

constexpr std::uint64_t magic = 0x31304d4544434c53;  // "SLCDEM01"

auto grain_arrays(auto& g)
{
    return std::array{&g.x,           &g.y,           &g.angle,           &g.vx,      &g.vy,      &g.spin,
                      &g.radius,      &g.mass,        &g.inertia,         &g.fx,      &g.fy,      &g.torque,
                      &g.external_fx, &g.external_fy, &g.external_torque, &g.half_vx, &g.half_vy, &g.half_spin};
}

template <class Archive, class AnyState>
void visit(Archive& archive, AnyState& s)
{
    archive(s.time);
    archive(s.steps);
    for (auto* array : grain_arrays(s.grains)) archive(*array);
    archive(s.pairs.first);
    archive(s.pairs.other);
    archive(s.pairs.spring);
    archive(s.pairs.sqrt_mass);
    archive(s.pairs.lossy_n);
    archive(s.pairs.lossy_t);
    archive(s.pairs.slides);
    for (auto& wall : s.wall_contacts) {
        archive(wall.active);
        archive(wall.grain);
        archive(wall.spring);
        archive(wall.lossy_n);
        archive(wall.lossy_t);
        archive(wall.slides);
    }
    archive(s.built_x);
    archive(s.built_y);
    archive(s.rebuilds);
    archive(s.booked);
    archive(s.power);
}

//! Every index within bounds: the kernels do not look.
bool is_consistent(State const& s, std::size_t grains)
{
    auto sized = [](auto const& array, std::size_t size) { return array.size() == size; };
    auto empty_or = [](auto const& array, std::size_t size) { return array.empty() || array.size() == size; };
    for (auto const* array : grain_arrays(s.grains))
        if (!sized(*array, grains)) return false;
    Pairs const& p = s.pairs;
    std::size_t const slots = p.other.size();
    bool ok = sized(s.built_x, grains) && sized(s.built_y, grains) && sized(p.first, grains + 1) && p.first[0] == 0 &&
              p.first.back() == slots && std::is_sorted(p.first.begin(), p.first.end()) && sized(p.spring, slots) &&
              sized(p.sqrt_mass, slots) && empty_or(p.lossy_n, slots) && empty_or(p.lossy_t, slots) &&
              empty_or(p.slides, slots) &&
              std::all_of(p.other.begin(), p.other.end(), [&](std::uint32_t j) { return j < grains; });
    for (WallContacts const& w : s.wall_contacts)
        ok = ok && sized(w.spring, w.grain.size()) && empty_or(w.lossy_n, w.grain.size()) &&
             empty_or(w.lossy_t, w.grain.size()) && empty_or(w.slides, w.grain.size()) &&
             std::all_of(w.grain.begin(), w.grain.end(), [&](std::uint32_t i) { return i < grains; });
    return ok;
}

}  // namespace

std::vector<std::byte> to_bytes(State const& state)
{
    ByteWriter writer;
    writer(magic);
    visit(writer, state);
    return std::move(writer.bytes);
}

State state_from_bytes(std::span<std::byte const> bytes, std::size_t grains, std::size_t walls)
{
    State state;
    state.wall_contacts.resize(walls);
    ByteReader reader(bytes);
    std::uint64_t seen = 0;
    reader(seen);
    if (seen == magic) visit(reader, state);
    sluice::require(seen == magic && reader.at_end() && is_consistent(state, grains), [&] {
        return sluice::Error("dem: the checkpoint is not a state of " + std::to_string(grains) + " grains and " +
                                 std::to_string(walls) +
                                 " walls (must come from the same scene). Resume from an older one.",
                             sluice::Exit::io);
    });
    return state;
}

}  // namespace dem
