#include "participants/dem/stress.hpp"

namespace dem {

template <int D>
double stress_across(Setup<D> const& setup, State<D> const& state) noexcept
{
    Grains<D> const& g = state.grains;
    int const across = setup.periodic.shear.across;
    double const low = component(setup.periodic.low, across), height = component(state.cell.extent, across);
    double sum = 0.0, volume = 1.0;  // sum over pairs of f (xi - xj - n h) = that over grains of F x, less f n h
    for (std::size_t i = 0; i < g.size(); ++i) {
        double const speed = component(g.motion[i].velocity, across);
        sum += component(g.contact[i].force, across) * (component(g.place[i].centre, across) - low) +
               g.mass[i] * speed * speed;
    }
    sum -= component(state.cell.pull[static_cast<std::size_t>(across)], across) * height;
    for (int k = 0; k < D; ++k) volume *= component(state.cell.extent, k);
    return sum / volume;
}

template double stress_across<2>(Setup<2> const&, State<2> const&) noexcept;
template double stress_across<3>(Setup<3> const&, State<3> const&) noexcept;

}  // namespace dem
