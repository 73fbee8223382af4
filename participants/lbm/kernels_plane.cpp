#include "participants/lbm/collide_plane.hpp"
#include "participants/lbm/kernels.hpp"

namespace lbm {
namespace {

template <class Stored, bool Les, bool Central, bool Force, bool Frame>
constexpr Kernels<2> kernels = {
    collide<Features{.les = Les, .force = Force, .frame = Frame, .central = Central}, Lanes<Stored>, Stored>,
    collide<Features{.les = Les, .force = Force, .grains = true, .frame = Frame, .central = Central}, Lanes<Stored>,
            Stored>};

template <class Stored, bool Les, bool Central>
Kernels<2> chosen(Features const& f)
{
    if (f.frame) return kernels<Stored, Les, Central, true, true>;
    return f.force ? kernels<Stored, Les, Central, true, false> : kernels<Stored, Les, Central, false, false>;
}

template <class Stored, bool Les>
Kernels<2> colliding(Features const& f)
{
    return f.central ? chosen<Stored, Les, true>(f) : chosen<Stored, Les, false>(f);
}

template <class Stored>
Kernels<2> stored_as(Features const& f)
{
    return f.les ? colliding<Stored, true>(f) : colliding<Stored, false>(f);
}

}  // namespace

template <>
Kernels<2> kernels_of<2>(Config const& config)
{
    Features const f = features_of(config);
    return config.precision == Precision::float64 ? stored_as<double>(f) : stored_as<float>(f);
}

}  // namespace lbm
