#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "coupler/scene/scene.hpp"
#include "participants/files/stl_file.hpp"
#include "participants/lbm/lattice_units.hpp"
#include "participants/lbm/output_config.hpp"

namespace sluice {
class Reader;
}

namespace lbm {

//! Of stored populations.
enum class Precision
{
    float64,
    float32
};
enum class Operator
{
    mrt,
    trt,
    bgk,
    central  //!< moments about the cell's velocity, collide_central.hpp
};
//! How moving bodies are in the lattice.
enum class Surface
{
    covered,       //!< a cell is solid in part, solid_weight.hpp
    interpolated,  //!< they cut the links between cells, links.hpp
    forced         //!< direct forcing: their share of a cell gets their velocity, solid_weight.hpp
};
//! What is beyond a side.
enum class Border
{
    wall,  //!< half-way bounce-back (no-slip), moving along itself if velocity != 0
    periodic,
    slip,     //!< a wall without friction
    inflow,   //!< its velocity is given
    pressure  //!< its pressure is given; flow may go either way
};

//! One side of the domain.
struct Wall
{
    Border kind = Border::wall;
    std::array<double, 3> velocity{};  //!< [m/s]; of a wall none across; of an inflow the largest
    bool parabola = false;             //!< of an inflow: falls to 0 at walls beside it, else it is uniform
    double ramp = 0;                   //!< an inflow grows from 0 within this time [s]
    double pressure = 0;               //!< p - p_0 [Pa]
    bool absorbing = false;            //!< of a pressure: sound leaves, and the pressure holds in the mean
};

//! The sides: lower and upper one along x, y and z.
enum Side : std::size_t
{
    left,
    right,
    lower_y,
    upper_y,
    lower_z,
    upper_z
};
//! In the plane y is up, in space z.
template <int D>
inline constexpr Side bottom = D == 2 ? lower_y : lower_z;
template <int D>
inline constexpr Side top = D == 2 ? upper_y : upper_z;

//! A solid at rest in the fluid. [m]
struct Solid
{
    enum class Shape
    {
        ball,      //!< a disc or a sphere
        box,       //!< along the axes
        cylinder,  //!< in space, along an axis, through the whole domain
        mesh       //!< in space, within a closed surface
    };
    std::string name;
    Shape shape = Shape::ball;
    std::array<double, 3> centre{};  //!< of a box its middle; torques are about it
    double radius = 0;
    std::array<double, 3> size{};            //!< of a box, or of the one about a mesh
    std::size_t axis = 0;                    //!< of a cylinder
    std::vector<files::Triangle> surface{};  //!< of a mesh [m]
};

//! How solids finer than a cell hinder the flow (drag_law.hpp).
enum class Drag
{
    ergun,
    carman_kozeny,
    di_felice
};

//! Solids finer than a cell, which a partner moves.
struct PhaseConfig
{
    Drag law = Drag::ergun;
    double diameter = 0;       //!< of their grains [m]
    double solid_density = 0;  //!< of a grain [kg/m3]
    int spread = 1;            //!< half width of the hat functions that spread a point [cells]
    bool matter = true;        //!< a point is a piece of a continuum; false: grains, each with a drag of its own
};

//! A uniform acceleration that swings, amplitude cos(2 pi frequency t).
struct Oscillation
{
    std::array<double, 3> amplitude{};  //!< [m/s2]
    double frequency = 0;               //!< [Hz]
};

//! Everything the solver needs, in SI; made by read_config() or by hand, constant afterwards.
struct Config
{
    int dimension = 2;
    std::array<double, 3> origin{};  //!< corner of the lowest coordinates [m]
    std::array<double, 3> size{};    //!< [m], a multiple of `cell` each way; in the plane no third
    double cell = 0;                 //!< dx [m]
    double step = 0;                 //!< dt [s]
    double density = 1000;           //!< rho_0 [kg/m3]
    double viscosity = 1e-6;         //!< kinematic [m2/s]
    double max_velocity = 0;         //!< the fastest expected [m/s]; for the Mach number alone
    Operator collision = Operator::mrt;
    double magic = 3.0 / 16;  //!< (tau - 1/2)(tau_q - 1/2) of MRT and TRT: 3/16 puts a flat wall exactly half-way
    std::optional<double> flux_rate;  //!< s_q of MRT, instead of `magic`
    double energy_rate = 1.2;         //!< s_e of MRT; the bulk viscosity is (1/s_e - 1/2)/3
    double square_rate = 1.2;         //!< s_eps of MRT
    double smagorinsky = 0;           //!< C_s, filter width dx; 0: no large-eddy model
    std::array<Wall, 6> walls{};      //!< indexed by Side
    std::vector<Solid> solids{};
    std::array<double, 3> acceleration{};  //!< of the whole fluid [m/s2]: force density rho_0 a
    std::optional<Oscillation> oscillation{};
    //! Of the frame: Coriolis' and Euler's acceleration act on the lattice, with `hydrostatic` the centrifugal one too.
    std::optional<sluice::Rotation> rotation{};
    bool hydrostatic = false;                  //!< gravity acts on the lattice
    Precision precision = Precision::float64;  //!< of the populations as they are stored
    Surface surface = Surface::covered;        //!< of bodies; solids at rest cover cells
    double lightest_grain = 0;                 //!< its density, if it is light beside the fluid [kg/m3]; 0: none is
    double hydrodynamic_radius = 1;            //!< the fluid sees a disc of this factor times its radius
    std::optional<PhaseConfig> phase{};
    OutputConfig output{};
    int threads = 1;

    LatticeUnits units() const noexcept { return {cell, step, density, dimension}; }
    double relaxation_time() const noexcept { return units().relaxation_time(viscosity); }
    std::array<std::ptrdiff_t, 3> cells() const noexcept;  //!< along x, y, z; one along z in the plane
    std::size_t axes() const noexcept { return static_cast<std::size_t>(dimension); }
    bool periodic(std::size_t axis) const noexcept { return walls[2 * axis].kind == Border::periodic; }
    void set_periodic(std::size_t axis, bool is = true) noexcept
    {
        walls[2 * axis].kind = walls[2 * axis + 1].kind = is ? Border::periodic : Border::wall;
    }
};

//! What is wrong with a configuration, or near a limit.
struct Issue
{
    std::string key;   //!< of the scene
    std::string text;  //!< `seen (needed). What to try.`
    bool refused;      //!< false: a warning
};

std::vector<Issue> find_issues(Config const& config);

//! tau, Mach number, grid Reynolds number and the like, one line each, for the start of a log.
std::vector<std::string> describe(Config const& config);

//! Reads a participant's `config:` block (keys: README.md) of a scene in the plane or in space. `gravity` [m/s2] is the
//! scene's; it enters the lattice if `gravity: true`. `rotation`: that of the scene's frame. `phase`: a partner sends
//! one. Every mistake becomes a problem of the reader.
Config read_config(sluice::Reader& reader, int dimension, std::array<double, 3> gravity,
                   std::optional<sluice::Rotation> const& rotation = std::nullopt, bool phase = false,
                   int processes = 1);

}  // namespace lbm
