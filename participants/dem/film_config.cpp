#include <algorithm>

#include "coupler/base/format.hpp"
#include "participants/dem/config_parts.hpp"
#include "participants/dem/state.hpp"

namespace dem {

void read_lubrication(sluice::Reader& r, Config& config)
{
    auto film = r.child_if("lubrication");
    if (!film) return;
    Lubrication& l = config.lubrication;
    l.viscosity = film->number("viscosity", {.above = 0.0, .max = 1e6, .unit = "Pa s"});
    l.cutoff = film->number("cutoff", {.above = 0.0, .max = 1e3, .unit = "m"});
    l.floor = film->number_or("floor", config.dimension == 2 ? 1e-2 : 1e-3, {.min = 1e-6, .max = 1.0});
    film->finish();
    if (config.scheme == Scheme::liggghts)
        r.problem("lubrication", "does not go with scheme: liggghts (leave one of them out).");
    if (config.periodic.is_sheared())
        r.problem("lubrication", "does not go with shear: its stress leaves the films out (leave one of them out).");
}

//! The film in the narrowest gap brakes within m*/c, which the step must resolve: a dashpot of velocity Verlet is
//! stable up to c dt/m* = 2 and loses what it should up to half of that.
void check_lubrication(sluice::Reader& r, Config& config)
{
    Lubrication const& l = config.lubrication;
    if (!l.any() || !r.diagnostics()->problems.empty()) return;
    for (WallConfig const& wall : config.walls)
        if (wall.mesh)
            r.problem("lubrication", "does not go with a mesh, here wall \"" + wall.name +
                                         "\" (leave one of them out, or build the wall of planes).");
    auto const [radius, mass] = lightest_grain(config);
    bool const plane = config.dimension == 2;
    // a pair has half the radius and half the mass of one at a wall
    auto const braking = [&](double effective, double of) {
        double const c = plane ? l.resistance<2>(0.0, effective) : l.resistance<3>(0.0, effective);
        return c > 0.0 ? of / c : std::numeric_limits<double>::infinity();
    };
    double const time = std::min(braking(0.5 * radius, 0.5 * mass), braking(radius, mass));
    if (config.step > 0.5 * time)
        r.problem("lubrication",
                  sluice::format(
                      "brakes within m/c = %g s in the narrowest gap (the step may be half of that, and is %g s). Give "
                      "a shorter step, or a larger floor.",
                      time, config.step));
}

}  // namespace dem
