#include "participants/lbm/collide_plane.hpp"
#include "participants/lbm/kernels.hpp"

namespace lbm {
namespace {

template <class Stored, bool Les, bool Force, bool Frame>
constexpr Kernels<2> kernels = {
    collide<Features{.les = Les, .force = Force, .frame = Frame}, Lanes<Stored>, Stored>,
    collide<Features{.les = Les, .force = Force, .grains = true, .frame = Frame}, Lanes<double>, Stored>};

template <class Stored, bool Les>
Kernels<2> chosen(Features const& f)
{
    if (f.frame) return kernels<Stored, Les, true, true>;
    return f.force ? kernels<Stored, Les, true, false> : kernels<Stored, Les, false, false>;
}

template <class Stored>
Kernels<2> stored_as(Features const& f)
{
    return f.les ? chosen<Stored, true>(f) : chosen<Stored, false>(f);
}

}  // namespace

template <>
Kernels<2> kernels_of<2>(Config const& config)
{
    Features const f = features_of(config);
    return config.precision == Precision::float64 ? stored_as<double>(f) : stored_as<float>(f);
}

}  // namespace lbm
