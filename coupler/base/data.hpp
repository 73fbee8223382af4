#pragma once

#include <string>
#include <vector>

namespace sluice {

//! What one point carries in a column: its number of values depends on the scene's dimension d.
enum class Shape
{
    scalar,  //!< 1
    vector,  //!< d
    spin     //!< angular velocity or torque: 1 in 2D, 3 in 3D
};

constexpr int components(Shape shape, int dimension)
{
    return shape == Shape::scalar ? 1 : shape == Shape::vector ? dimension : dimension == 2 ? 1 : 3;
}

//! One named column of a frame.
struct ColumnSpec
{
    std::string name;
    Shape shape = Shape::scalar;
    std::string unit;
    bool operator==(ColumnSpec const&) const = default;
};

//! What flows on an edge: named columns over points with lasting ids.
struct DataSpec
{
    std::string name;
    std::vector<ColumnSpec> columns;
    bool meshless = false;  //!< one point without a place: a number, a signal
    bool additive = false;  //!< what several processes say of one point adds up, e.g. parts of a force
    bool operator==(DataSpec const&) const = default;
};

//! The built-in data; a scene may declare more.
inline std::vector<DataSpec> const& vocabulary()
{
    static std::vector<DataSpec> const data = {
        {"kinematics",
         {{"position", Shape::vector, "m"},
          {"velocity", Shape::vector, "m/s"},
          {"angular_velocity", Shape::spin, "rad/s"},
          {"radius", Shape::scalar, "m"}},
         false,
         false},
        {"load", {{"force", Shape::vector, "N"}, {"torque", Shape::spin, "N m"}}, false, true},
        {"phase",
         {{"position", Shape::vector, "m"}, {"velocity", Shape::vector, "m/s"}, {"solid_volume", Shape::scalar, "m3"}},
         false,
         false},
        {"body_force", {{"force", Shape::vector, "N"}}, false, true},
    };
    return data;
}

}  // namespace sluice
