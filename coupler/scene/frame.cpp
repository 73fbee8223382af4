#include <algorithm>
#include <cmath>

#include "coupler/scene/parts.hpp"

namespace sluice {
namespace {

void copy(std::vector<double> const& from, std::array<double, 3>& to)
{
    std::copy(from.begin(), from.end(), to.begin());
}

void read_direction(Reader& reader, Rotation& rotation)
{
    copy(reader.numbers_or("direction", {0, 1, 0}), rotation.direction);
    auto& [x, y, z] = rotation.direction;
    double const length = std::sqrt(x * x + y * y + z * z);
    if (length > 0)
        for (double& component : rotation.direction) component /= length;
    else
        reader.refuse("direction", "points nowhere (must not be zero).");
}

}  // namespace

void read_frame(Reader& root, Scene& scene)
{
    if (!root.has("frame") || root.is_scalar("frame")) {
        root.choice_or("frame", 0, {"inertial"});
        return;
    }
    auto frame = root.child_if("frame");
    if (!frame) return;
    auto reader = frame->child("rotating");
    Rotation rotation;
    copy(reader.numbers("axis", static_cast<std::size_t>(scene.dimension), {.unit = "m"}), rotation.point);
    if (scene.dimension == 3) read_direction(reader, rotation);
    rotation.rate = reader.number("rate", {.unit = "rad/s"});
    rotation.ramp = reader.number_or("ramp", 0.0, {.min = 0.0, .unit = "s"});
    rotation.centrifugal = reader.flag_or("centrifugal", true);
    rotation.coriolis = reader.flag_or("coriolis", true);
    rotation.euler = reader.flag_or("euler", true);
    reader.finish();
    frame->finish();
    scene.rotation = rotation;
    scene.frame_place = root.place("frame");
}

}  // namespace sluice
