#include "participants/liggghts/observer.hpp"

#include <limits>
#include <utility>

#include "coupler/base/error.hpp"

namespace liggghts {

template <int D>
Observer<D>::Observer(dem::Setup<D> setup) : setup_(std::move(setup))
{
    setup_.features = {.elasticity = setup_.features.elasticity};  // of the laws only what places say
    setup_.threads = 1;
}

template <int D>
dem::Solver<D> const& Observer<D>::look(dem::Grains<D> const& grains, double time, double work)
{
    dem::Setup<D> now = setup_;
    std::erase_if(now.walls, [&](dem::Wall<D> const& wall) { return !(wall.removed_at > time); });
    for (auto const& wall : now.walls)
        for (std::size_t i = 0; i < grains.size(); ++i)
            sluice::require(dem::facing_at_start(wall, grains.place[i].centre).distance > 0.0, [&] {
                return sluice::Error("LIGGGHTS: the centre of grain " + std::to_string(grains.id[i]) +
                                         " is behind wall \"" + wall.name +
                                         "\" (LIGGGHTS' walls hold grains on both sides, ours on one). Try stiffer "
                                         "contacts, or a shorter step.",
                                     sluice::Exit::numerical);
            });
    seen_.emplace(std::move(now), grains);
    dem::State<D> state = seen_->state();
    state.time = time;
    constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
    state.booked = {.normal_dashpot = unknown,
                    .tangential_dashpot = unknown,
                    .sliding = unknown,
                    .rolling = unknown,
                    .external_work = work,
                    .removed_walls = unknown};
    seen_->restore(std::move(state));
    return *seen_;
}

template class Observer<2>;
template class Observer<3>;

}  // namespace liggghts
