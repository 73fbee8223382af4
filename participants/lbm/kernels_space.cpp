#include "participants/lbm/collide_space.hpp"
#include "participants/lbm/kernels.hpp"

namespace lbm {
namespace {

template <bool Les, bool Split, bool Force, bool Frame>
constexpr Kernels<3> kernels = {
    collide<Features{.les = Les, .force = Force, .split = Split, .frame = Frame}>,
    collide<Features{.les = Les, .force = Force, .grains = true, .split = Split, .frame = Frame}>};

template <bool Les, bool Split>
Kernels<3> chosen(Features const& f)
{
    if (f.frame) return kernels<Les, Split, true, true>;
    return f.force ? kernels<Les, Split, true, false> : kernels<Les, Split, false, false>;
}

}  // namespace

template <>
Kernels<3> kernels_of<3>(Config const& config)
{
    Features const f = features_of(config);
    if (f.les) return chosen<true, false>(f);
    return f.split ? chosen<false, true>(f) : chosen<false, false>(f);
}

}  // namespace lbm
