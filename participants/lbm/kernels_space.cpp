#include "participants/lbm/kernels_space.hpp"

namespace lbm {

extern template Kernels<3> space_kernels<float>(Features const&);

template <>
Kernels<3> kernels_of<3>(Config const& config)
{
    Features const f = features_of(config);
    return config.precision == Precision::float64 ? space_kernels<double>(f) : space_kernels<float>(f);
}

}  // namespace lbm
