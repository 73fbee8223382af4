#pragma once

#include <cmath>

//! Vectors of the plane (x right, y up) and of space (x, y horizontal, z up), and what differs between the two: how
//! bodies turn, and the directions along a contact.
namespace dem {

template <int D>
struct Vec;

template <>
struct Vec<2>
{
    double x = 0.0, y = 0.0;
    bool operator==(Vec const&) const = default;
};
template <>
struct Vec<3>
{
    double x = 0.0, y = 0.0, z = 0.0;
    bool operator==(Vec const&) const = default;
};
using Vec2 = Vec<2>;
using Vec3 = Vec<3>;

constexpr Vec2 operator+(Vec2 a, Vec2 b) noexcept
{
    return {a.x + b.x, a.y + b.y};
}
constexpr Vec2 operator-(Vec2 a, Vec2 b) noexcept
{
    return {a.x - b.x, a.y - b.y};
}
constexpr Vec2 operator*(double s, Vec2 a) noexcept
{
    return {s * a.x, s * a.y};
}
constexpr double dot(Vec2 a, Vec2 b) noexcept
{
    return a.x * b.x + a.y * b.y;
}
constexpr Vec3 operator+(Vec3 a, Vec3 b) noexcept
{
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
constexpr Vec3 operator-(Vec3 a, Vec3 b) noexcept
{
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
constexpr Vec3 operator*(double s, Vec3 a) noexcept
{
    return {s * a.x, s * a.y, s * a.z};
}
constexpr double dot(Vec3 a, Vec3 b) noexcept
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
constexpr Vec3 cross(Vec3 a, Vec3 b) noexcept
{
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
//! Also for the numbers that stand for vectors in the plane (spins, tangents).
constexpr double dot(double a, double b) noexcept
{
    return a * b;
}
template <class V>
double norm(V const& a) noexcept
{
    return std::sqrt(dot(a, a));
}
template <int D>
Vec<D>& operator+=(Vec<D>& a, Vec<D> const& b) noexcept
{
    return a = a + b;
}
template <int D>
Vec<D>& operator-=(Vec<D>& a, Vec<D> const& b) noexcept
{
    return a = a - b;
}
template <int D>
Vec<D> operator-(Vec<D> const& a) noexcept
{
    return -1.0 * a;
}

//! A unit vector across an axis (a unit vector): any.
inline Vec3 across(Vec3 axis) noexcept
{
    Vec3 const trial = std::abs(axis.x) < 0.5 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
    Vec3 const flat = trial - dot(trial, axis) * axis;
    return (1.0 / norm(flat)) * flat;
}

//! The component against gravity, as scenes have it.
template <int D>
constexpr double up(Vec<D> const& a) noexcept
{
    if constexpr (D == 2)
        return a.y;
    else
        return a.z;
}

//! Component k = 0 .. D-1.
template <int D>
constexpr double& component(Vec<D>& a, int k) noexcept
{
    if constexpr (D == 3)
        if (k == 2) return a.z;
    return k == 0 ? a.x : a.y;
}
template <int D>
constexpr double component(Vec<D> const& a, int k) noexcept
{
    Vec<D> copy = a;
    return component<D>(copy, k);
}

//! Calls `each` for the numbers of a vector, or of a number that stands for one.
template <class Each>
void each_number(double& number, Each&& each)
{
    each(number);
}
template <int D, class Each>
void each_number(Vec<D>& v, Each&& each)
{
    for (int k = 0; k < D; ++k) each(component<D>(v, k));
}

//! What stands for turning and for tangents: a number in the plane (counter-clockwise; along the normal turned by +90
//! degrees), a vector in space.
template <int D>
struct Turning
{
    using Type = Vec3;
};
template <>
struct Turning<2>
{
    using Type = double;
};
//! Angular velocity [rad/s], torque [N m], rotation [rad].
template <int D>
using Spin = typename Turning<D>::Type;
//! A vector in the tangent plane of a contact: slip, elongation, friction.
template <int D>
using Tangent = typename Turning<D>::Type;

//! The unit tangent of the plane: the normal turned by +90 degrees.
constexpr Vec2 tangent_of(Vec2 normal) noexcept
{
    return {-normal.y, normal.x};
}

//! A tangent as a vector of space.
constexpr Vec2 vector_of(double tangent, Vec2 normal) noexcept
{
    return tangent * tangent_of(normal);
}
constexpr Vec3 vector_of(Vec3 tangent, Vec3) noexcept
{
    return tangent;
}

//! The part of a velocity along the contact.
constexpr double along(Vec2 velocity, Vec2 normal) noexcept
{
    return dot(velocity, tangent_of(normal));
}
constexpr Vec3 along(Vec3 velocity, Vec3 normal) noexcept
{
    return velocity - dot(velocity, normal) * normal;
}

//! spin x n, as a tangent: the velocity that a spin gives to a point at n from the axis.
constexpr double turning_about(double spin, Vec2) noexcept
{
    return spin;
}
constexpr Vec3 turning_about(Vec3 spin, Vec3 normal) noexcept
{
    return cross(spin, normal);
}

//! n x tangent, as a torque.
constexpr double torque_of(double tangent, Vec2) noexcept
{
    return tangent;
}
constexpr Vec3 torque_of(Vec3 tangent, Vec3 normal) noexcept
{
    return cross(normal, tangent);
}

//! A tangent carried to the contact's new place: turned about the normal by `twist` [rad], then into the tangent plane
//! with its length kept. In the plane the tangent turns with the contact by itself.
constexpr double carried(double tangent, Vec2, double) noexcept
{
    return tangent;
}
inline Vec3 carried(Vec3 tangent, Vec3 normal, double twist) noexcept
{
    double const square = dot(tangent, tangent);
    Vec3 const turned = tangent + twist * cross(normal, tangent);
    Vec3 const flat = turned - dot(turned, normal) * normal;
    double const left = dot(flat, flat);
    return left > 0.0 ? std::sqrt(square / left) * flat : Vec3{};
}

//! How fast two partners turn together about the normal [rad/s]; nothing in the plane.
constexpr double twist_of(double, double, Vec2) noexcept
{
    return 0.0;
}
constexpr double twist_of(Vec3 spin_i, Vec3 spin_j, Vec3 normal) noexcept
{
    return 0.5 * dot(spin_i + spin_j, normal);
}

}  // namespace dem
