#include "participants/lbm/collide_plane.hpp"
#include "participants/lbm/kernels.hpp"

namespace lbm {
namespace {

template <bool Les, bool Force, bool Frame>
constexpr Kernels<2> kernels = {collide<Features{.les = Les, .force = Force, .frame = Frame}>,
                                collide<Features{.les = Les, .force = Force, .grains = true, .frame = Frame}>};

template <bool Les>
Kernels<2> chosen(Features const& f)
{
    if (f.frame) return kernels<Les, true, true>;
    return f.force ? kernels<Les, true, false> : kernels<Les, false, false>;
}

}  // namespace

template <>
Kernels<2> kernels_of<2>(Config const& config)
{
    Features const f = features_of(config);
    return f.les ? chosen<true>(f) : chosen<false>(f);
}

}  // namespace lbm
