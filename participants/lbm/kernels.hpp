#pragma once

#include "participants/lbm/cell_row.hpp"
#include "participants/lbm/config.hpp"
#include "participants/lbm/still_cells.hpp"

namespace lbm {

//! Collides cells in place.
template <int D>
using Kernel = void (*)(AnySlots<D> const&, CellRows const&, Relaxation const&, AnySolidRow const&);

template <int D>
using StillKernel = void (*)(AnySlots<D> const&, AnyStillBlock const&, Relaxation const&);

//! Those of a run: of cells without solids, and with them. What is stored as floats is computed with as floats.
template <int D>
struct Kernels
{
    Kernel<D> fluid = nullptr, covered = nullptr;
    StillKernel<D> still = nullptr;  //!< of rows in which solids rest; in space, but for central moments
};

//! Defined for the plane and for space in files of their own: compiling them takes a while.
template <int D>
Kernels<D> kernels_of(Config const& config);
template <>
Kernels<2> kernels_of<2>(Config const& config);
template <>
Kernels<3> kernels_of<3>(Config const& config);

//! What a run needs of its kernels.
inline Features features_of(Config const& c)
{
    bool const les = c.smagorinsky > 0;
    return {.les = les,
            .force = c.acceleration != std::array<double, 3>{} || c.oscillation || c.rotation,
            .split = c.dimension == 3 && c.collision == Operator::mrt && !les,
            .frame = c.rotation.has_value(),
            .central = c.collision == Operator::central};
}

}  // namespace lbm
