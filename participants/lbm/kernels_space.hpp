#pragma once

#include "participants/lbm/collide_still.hpp"
#include "participants/lbm/kernels.hpp"

namespace lbm {

template <class Stored, bool Les, bool Split, bool Central, bool Force, bool Frame>
constexpr Kernels<3> kernels_with()
{
    constexpr Features fluid{.les = Les, .force = Force, .split = Split, .frame = Frame, .central = Central},
        covered{.les = Les, .force = Force, .grains = true, .split = Split, .frame = Frame, .central = Central},
        still{.les = Les, .force = Force, .grains = true, .still = true, .split = Split, .frame = Frame};
    Kernels<3> all{collide<fluid, Lanes<Stored>, Stored>, collide<covered, Lanes<Stored>, Stored>};
    if constexpr (!Central) all.still = collide_still<fluid, still, Stored>;
    return all;
}
template <class Stored, bool Les, bool Split, bool Central, bool Force, bool Frame>
constexpr Kernels<3> kernels = kernels_with<Stored, Les, Split, Central, Force, Frame>();

template <class Stored, bool Les, bool Split, bool Central>
Kernels<3> chosen(Features const& f)
{
    if (f.frame) return kernels<Stored, Les, Split, Central, true, true>;
    return f.force ? kernels<Stored, Les, Split, Central, true, false>
                   : kernels<Stored, Les, Split, Central, false, false>;
}

//! Defined for each type in a file of its own: compiling them takes a while.
template <class Stored>
Kernels<3> space_kernels(Features const& f)
{
    if (f.central) return f.les ? chosen<Stored, true, false, true>(f) : chosen<Stored, false, false, true>(f);
    if (f.les) return chosen<Stored, true, false, false>(f);
    return f.split ? chosen<Stored, false, true, false>(f) : chosen<Stored, false, false, false>(f);
}

}  // namespace lbm
