#include <numbers>
#include <string>

#include "coupler/base/format.hpp"
#include "participants/dem/config_parts.hpp"

namespace dem {

void read_sleep(sluice::Reader& r, Config& config)
{
    auto sleep = r.child_if("sleep");
    if (!sleep) return;
    config.sleep.speed = sleep->number("speed", {.above = 0.0, .max = 1e3, .unit = "m/s"});
    config.sleep.time = sleep->number("time", {.above = 0.0, .unit = "s"});
    sleep->finish();
    auto const refuse = [&](bool does, char const* why) {
        if (does) r.problem("sleep", std::string(why) + " (leave one of them out): grains at rest would not feel it.");
    };
    // an oscillation of that speed changes the forces by m w v, w = pi/t_c: they stay so when it falls asleep
    double const shaken = std::numbers::pi / config.contact_time * config.sleep.speed, gravity = norm(config.gravity);
    if (gravity > 0.0 && shaken > 0.1 * gravity)
        config.warnings.push_back(sluice::format(
            "dem: sleep.speed lets grains fall asleep whose forces are out of balance by up to %g of their weight. "
            "Below %g m/s it is 0.01.",
            shaken / gravity, 0.01 * gravity * config.contact_time / std::numbers::pi));
    refuse(config.gravity_ramp > 0.0, "does not go with gravity_ramp");
    refuse(config.rotation && config.rotation->ramp > 0.0, "does not go with a frame that spins up");
    refuse(config.periodic.is_sheared(), "does not go with shear");
}

}  // namespace dem
