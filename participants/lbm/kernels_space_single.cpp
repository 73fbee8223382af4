#include "participants/lbm/kernels_space.hpp"

namespace lbm {

template Kernels<3> space_kernels<float>(Features const&);

}  // namespace lbm
