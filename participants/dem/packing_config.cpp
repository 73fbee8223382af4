#include <algorithm>

#include "coupler/base/checksum.hpp"
#include "coupler/base/error.hpp"
#include "coupler/scene/beside_scene.hpp"
#include "participants/dem/bytes.hpp"
#include "participants/dem/config_parts.hpp"
#include "participants/dem/grain_file.hpp"

namespace dem {
namespace {

//! Of all that makes these grains what they are, in their order; not 0.
std::uint64_t hash_of(std::vector<GrainConfig> const& grains)
{
    ByteWriter all;
    for (GrainConfig const& g : grains) {
        for (Vec3 const& v : {g.position, g.velocity, g.spin}) all(v);
        all(g.radius), all(g.density), all(g.id);
    }
    return std::max<std::uint64_t>(1, sluice::checksum_of(all.bytes));
}

}  // namespace

void read_packing(sluice::Reader r, Config& config)
{
    std::filesystem::path const file = r.text("file");
    auto const timestep = r.integer_if("timestep", {.min = 0, .max = 9e15});
    bool const at_rest = r.choice_or("velocities", 0, {"kept", "zero"}) == 1;
    r.finish();
    if (file.empty()) return;
    config.grains_from = sluice::beside_scene(r, file).string();
    try {
        config.grains = read_grain_file(config.grains_from, config.dimension, timestep, config.warnings);
    } catch (sluice::Error const& e) {
        r.refuse("file", std::string("cannot be used: ") + e.what());
        return;
    }
    for (GrainConfig& g : config.grains)
        if (at_rest) g.velocity = g.spin = {};
    sort_in_space(config.grains);
    config.grains_hash = hash_of(config.grains);
}

void read_density(sluice::Reader& r, Config& config)
{
    sluice::Bounds const bounds{.min = 1.0, .max = 1e5, .unit = "kg/m3"};
    bool const broken = !config.grains_from.empty() && config.grains.empty();
    bool const own = !config.grains.empty() && config.grains[0].density > 0.0;  // then all have
    if (!broken && !own) {
        config.density = r.number("density", bounds);
        return;
    }
    auto const given = r.number_if("density", bounds);
    config.density = given ? *given : own ? config.grains[0].density : 0.0;
    if (given)
        for (GrainConfig& g : config.grains) g.density = 0.0;
}

}  // namespace dem
