#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "coupler/scene/reader.hpp"
#include "participants/dem/vec2.hpp"

//! What a scene says about the grains, as plain constant data. The keys are in README.md.
namespace dem {

struct ContactConfig
{
    double normal_stiffness = 0.0;      //!< kn [N/m]
    double damping_ratio = 0.0;         //!< alpha_n [-]
    double tangential_stiffness = 0.0;  //!< kt [N/m]
    double tangential_damping = 0.0;    //!< alpha_t [-]
    double friction = 0.0;              //!< mu between grains [-]
};

struct WallConfig
{
    std::string name;
    Vec2 point;                                                   //!< [m]
    Vec2 normal;                                                  //!< unit vector, to the grains
    double friction = 0.0;                                        //!< mu [-]
    double removed_at = std::numeric_limits<double>::infinity();  //!< [s]
};

//! A settled column between the wall x = 0 and a gate, on the floor y = 0.
struct ColumnConfig
{
    std::int64_t count = 0;
    double aspect_ratio = 0.0;  //!< height / width, at the assumed packing fraction [-]
    std::uint64_t seed = 1;
    double gate_removed_at = 0.0;   //!< [s]
    double packing_friction = 0.0;  //!< mu while the column is poured [-]; lower: denser
};

struct GrainConfig
{
    Vec2 position;      //!< [m]
    double radius;      //!< [m]
    Vec2 velocity;      //!< [m/s]
    double spin = 0.0;  //!< [rad/s]
};

struct Config
{
    Vec2 gravity;                                   //!< [m/s2]
    double density = 0.0;                           //!< [kg/m3]
    double fluid_density = 0.0;                     //!< of the buoyancy [kg/m3]; 0: dry
    double diameter_min = 0.0, diameter_max = 0.0;  //!< of a column, uniform by number [m]
    ContactConfig contact;
    std::vector<WallConfig> walls;
    std::optional<ColumnConfig> column;
    std::vector<GrainConfig> grains;
    double step = 0.0;                  //!< longest step [s]
    double contact_time = 0.0;          //!< t_c of the lightest pair [s]
    std::vector<std::string> warnings;  //!< for the user, one sentence each
};

//! Packing fraction that turns count and aspect ratio into a width [-]; 2D discs of dmax/dmin = 1.8 (D07: 0.81-0.84).
inline constexpr double assumed_packing_fraction = 0.82;

//! Width of a column [m]:  sqrt(N pi (d^2)_mean / 4 / 0.82 / aspect ratio)
double column_width(Config const& config);

//! Reads and checks a grains block. Mistakes go to the reader; `reader.finish()` is called.
Config read_config(sluice::Reader reader, Vec2 gravity);

}  // namespace dem
