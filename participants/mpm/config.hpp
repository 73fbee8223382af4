#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "participants/mpm/state.hpp"

namespace sluice {
class Reader;
}

namespace mpm {

//! Matter that fills a box or a ball (a disc in the plane) at the start. In the plane third numbers are 0.
struct BodyConfig
{
    bool ball = false;
    std::array<double, 3> low{}, high{};  //!< of the box [m]
    std::array<double, 3> centre{};       //!< of the ball [m]
    double radius = 0;                    //!< [m]
    std::array<double, 3> velocity{};     //!< [m/s]
};

//! The stress of the matter's own weight below a level surface.
struct GeostaticConfig
{
    double surface = 0;  //!< height [m]
    double k0 = 0;       //!< horizontal over vertical stress [-]
};

//! What a column was before it fell; for the summary.
struct ColumnConfig
{
    double width = 0, height = 0;  //!< [m]
};

//! The fluid in the pores of the matter, which a partner computes.
struct FluidConfig
{
    double density = 0;   //!< [kg/m3]
    double porosity = 0;  //!< of the matter at the start [-]
};

//! Everything the solver needs, in SI; made by read_config() or by hand, constant afterwards.
struct Config
{
    int dimension = 2;
    std::array<double, 3> gravity{};           //!< [m/s2]
    std::optional<sluice::Rotation> rotation;  //!< of the frame of reference; absent: inertial
    std::array<double, 3> origin{};            //!< lower corner of the domain [m]
    std::array<double, 3> size{};              //!< [m], a whole number of cells
    double cell = 0;                           //!< h [m]
    int points = 2;                            //!< in a cell, along each axis
    BasisKind basis = BasisKind::gimp;
    Width width = Width::fixed;
    Symmetry symmetry = Symmetry::plane;  //!< in the plane
    Scheme scheme = Scheme::musl;
    double flip = 0.99;          //!< share of FLIP
    bool affine = true;          //!< points bring the gradient of their velocity to the grid; not with hat functions
    bool shared_volume = false;  //!< the points of a cell share its change of volume
    double damping = 0;          //!< [1/s]
    double courant = 0.4;
    std::optional<double> step;  //!< [s]; absent: auto
    double density = 0;          //!< [kg/m3]; beside a fluid less that of what it displaces
    std::optional<FluidConfig> fluid;
    Law law = LinearElastic{};
    std::vector<BodyConfig> bodies;
    std::optional<ColumnConfig> column;
    std::vector<Wall> walls;
    std::vector<Plate<3>> plates;
    std::optional<GeostaticConfig> geostatic;
    std::optional<double>
        front_depth;  //!< of the matter at what is called its front [m]; absent: 5 % of the root of its area
    std::optional<double> grain_friction;  //!< of the matter on the grains of a partner
    int threads = 1;
};

//! What a scene has beside the block.
struct Beside
{
    bool grains = false;                         //!< a partner sends some
    bool fluid = false;                          //!< a partner computes that in the pores
    sluice::Rotation const* rotation = nullptr;  //!< of the frame of reference; null: inertial
    int processes = 1;                           //!< that share the cores
};

//! Reads a participant's `config:` block (keys: README.md). Every mistake becomes a problem of the reader; finish()
//! throws them.
Config read_config(sluice::Reader& reader, int dimension, std::array<double, 3> const& gravity,
                   Beside const& beside = {});

}  // namespace mpm
