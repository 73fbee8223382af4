#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "coupler/scene/scene.hpp"
#include "participants/dem/laws.hpp"
#include "participants/dem/measure_config.hpp"
#include "participants/dem/periodic_cell.hpp"
#include "participants/dem/sizes.hpp"
#include "participants/dem/state.hpp"
#include "participants/dem/vec.hpp"
#include "participants/dem/wall_shape.hpp"

//! What a scene says about the grains, as plain constant data. The keys are in README.md. Vectors have three
//! components; in the plane z is 0.
namespace dem {

struct ContactConfig
{
    Elasticity elasticity = Elasticity::linear;
    double normal_stiffness = 0.0;      //!< linear: kn [N/m]
    double youngs_modulus = 0.0;        //!< hertz: E [Pa]
    double poissons_ratio = 0.0;        //!< hertz: nu [-]
    double damping_ratio = 0.0;         //!< alpha_n [-]
    double tangential_stiffness = 0.0;  //!< linear: kt [N/m]
    double tangential_damping = 0.0;    //!< alpha_t [-]
    double friction = 0.0;              //!< mu [-]
    Rolling rolling = Rolling::none;
    double rolling_friction = 0.0;   //!< mu_r [-]
    double rolling_stiffness = 0.0;  //!< kr/kt [-]
    double rolling_damping = 0.0;    //!< alpha_r [-]
    bool may_pull = false;           //!< the dashpot may make the normal force attractive
};

//! A surface of triangles in space, of segments in the plane.
struct MeshConfig
{
    std::string from;                         //!< the file; empty: the scene
    std::vector<std::array<Vec3, 3>> corner;  //!< of each facet [m]; a segment has two
    std::uint64_t hash = 0;                   //!< of all corners
};

struct WallConfig
{
    std::string name;
    Vec3 point;           //!< [m]
    Vec3 normal;          //!< plane: unit vector, to the grains; cylinder: of its axis ({} in the plane); mesh: {}
    double radius = 0.0;  //!< of a cylinder [m]; 0: a plane or a mesh
    bool inside = true;   //!< cylinder: the grains are inside
    std::shared_ptr<MeshConfig const> mesh;  //!< null: a plane or a cylinder
    ContactConfig contact;
    WallMotion<3> motion;
    double removed_at = std::numeric_limits<double>::infinity();  //!< [s]
};

//! What a column of grains stands in until its gate is removed.
enum class Container : unsigned char
{
    box,      //!< between the wall x = 0 and a gate, on the floor; in space between y = 0 and y = depth
    quarter,  //!< a quarter of a cylinder about the vertical axis, x > 0, y > 0
    cylinder  //!< about the vertical axis
};

//! How a column's grains come together before they settle.
enum class Preparation : unsigned char
{
    poured,
    random,  //!< grown among each other without weight until the column is full
    regular  //!< a lattice of the largest diameter: rows of triangles, layers as close as they can be
};

//! A settled column on the floor through the origin.
struct ColumnConfig
{
    Container container = Container::box;
    std::int64_t count = 0;
    double aspect_ratio = 0.0;  //!< height / width, at the packing fraction [-]
    double depth = 0.0;         //!< of a box in space [m]
    std::uint64_t seed = 1;
    double gate_removed_at = 0.0;   //!< [s]
    double packing_friction = 0.0;  //!< mu while the column is poured [-]; lower: denser
    Preparation preparation = Preparation::poured;
    double packing_fraction = 0.0;  //!< that width and height are reckoned with, and `random` is grown to [-]
    double pouring_gravity = 0.0;   //!< under which grains settle first [m/s2]; 0: the scene's own, at once
};

struct GrainConfig
{
    Vec3 position;         //!< [m]
    double radius;         //!< [m]
    Vec3 velocity;         //!< [m/s]
    Vec3 spin;             //!< [rad/s]; in the plane z
    double density = 0.0;  //!< [kg/m3]; 0: that of the scene
    std::int64_t id = -1;  //!< lasting; -1: its place in the list
};

//! Grains that fill a periodic cell loosely, each at a random place of its own.
struct FillConfig
{
    std::int64_t count = 0;
    std::uint64_t seed = 1;
};

//! Where stress, fabric and packing fraction are averaged: the whole periodic cell, or a box.
struct AverageConfig
{
    std::string name;
    bool whole = true;
    Vec3 low, high;  //!< of the box [m]
};

struct Config
{
    int dimension = 2;
    Vec3 gravity;                              //!< [m/s2]
    Vec3 first_gravity;                        //!< at t = 0, where it changes
    double gravity_ramp = 0.0;                 //!< time in which it becomes `gravity`, evenly [s]
    std::optional<sluice::Rotation> rotation;  //!< of the frame of reference; absent: inertial
    double density = 0.0;                      //!< [kg/m3]
    double fluid_density = 0.0;                //!< of the buoyancy [kg/m3]; 0: dry
    Lubrication lubrication;
    Sleep sleep;
    double diameter_min = 0.0, diameter_max = 0.0;  //!< of a column [m]
    Sizes sizes;                                    //!< of a column
    ContactConfig contact;
    Scheme scheme = Scheme::predicted;
    int threads = 1;
    bool loads = true;  //!< a partner may act on the grains; not in the scene's block
    std::vector<WallConfig> walls;
    std::optional<ColumnConfig> column;
    std::vector<GrainConfig> grains;
    std::string grains_from;        //!< the file that they are from; empty: the scene
    std::uint64_t grains_hash = 0;  //!< of all that the file says about them; 0: no file
    MeasuresConfig measures;
    std::optional<FillConfig> fill;
    Periodic<3> periodic;
    std::vector<AverageConfig> averages;
    double step = 0.0;                  //!< longest step [s]
    double contact_time = 0.0;          //!< t_c of the lightest pair [s]
    std::vector<std::string> warnings;  //!< for the user, one sentence each
};

//! Packing fraction that turns count and aspect ratio into a width [-]. Discs of dmax/dmin = 1.8: 0.81-0.84 (D07);
//! poured spheres with little friction: 0.60-0.62 (study C: 0.611).
constexpr double assumed_packing_fraction(int dimension)
{
    return dimension == 2 ? 0.82 : 0.61;
}

//! Gravity when the run begins; if it grows from nothing, what it grows to [m/s2].
Vec3 starting_gravity(Config const& config);
//! What a column is poured under: that, and the centrifugal part at the origin when the run begins [m/s2].
Vec3 settling_gravity(Config const& config);

//! Width (box) or radius of a column [m], from the volume of its grains.
double column_width(Config const& config);

//! Reads and checks a grains block for a scene of this dimension. Mistakes go to the reader; `reader.finish()` is
//! called.
Config read_config(sluice::Reader reader, int dimension, Vec3 gravity,
                   std::optional<sluice::Rotation> const& rotation = {});

//! Smallest and largest diameter of the grains [m].
std::pair<double, double> diameters(Config const& config);
//! Reach of the neighbour list beyond contact [m]. Measured: speed is flat from 0.1 to 0.3 of the smallest diameter.
constexpr double list_reach(double smallest_diameter)
{
    return 0.2 * smallest_diameter;
}

//! The periodic sides and their shear; what has to do with the grains is looked at once they and the step are known.
void read_periodic(sluice::Reader& reader, Config& config);
void read_fill(sluice::Reader& reader, Config& config);
void check_periodic(sluice::Reader& reader, Config& config);
void read_averages(sluice::Reader& reader, Config& config);
//! Edge of the cells of a grid, one for each grain that fills the cell [m]; at least the largest diameter fits.
double fill_pitch(Config const& config);

//! The contact block; walls start from `fallback`, that of the grains.
ContactConfig read_contact(sluice::Reader reader, std::optional<ContactConfig> const& fallback = std::nullopt);
//! `friction: mu` or `friction_angle: degrees`; exactly one where there is no fallback.
double read_friction(sluice::Reader& reader, std::optional<double> fallback);

//! The laws of a contact block, with the stiffnesses of two partners of the same matter.
ContactLaw contact_law(ContactConfig const& contact);

//! Half period of the stiffest mode of a pair of grains of mass m [kg], radius r [m], at the step's reference [s]:
//! for hertz at an overlap of 1 % of the radius.
double contact_time_of(ContactConfig const& contact, int dimension, double mass, double radius);

template <int D>
Vec<D> to_dimension(Vec3 const& v)
{
    if constexpr (D == 2)
        return {v.x, v.y};
    else
        return v;
}
constexpr Vec3 in_space(Vec2 v)
{
    return {v.x, v.y, 0.0};
}
constexpr Vec3 in_space(Vec3 v)
{
    return v;
}

}  // namespace dem
