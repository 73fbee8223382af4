#pragma once

namespace dem {

//! A vector of the plane: x to the right, y up.
struct Vec2
{
    double x = 0.0;
    double y = 0.0;
};

inline Vec2 operator+(Vec2 a, Vec2 b) noexcept
{
    return {a.x + b.x, a.y + b.y};
}
inline Vec2 operator-(Vec2 a, Vec2 b) noexcept
{
    return {a.x - b.x, a.y - b.y};
}
inline Vec2 operator*(double s, Vec2 a) noexcept
{
    return {s * a.x, s * a.y};
}
inline double dot(Vec2 a, Vec2 b) noexcept
{
    return a.x * b.x + a.y * b.y;
}

//! The tangent that goes with a unit normal: the normal turned by +90 degrees.
inline Vec2 tangent_of(Vec2 normal) noexcept
{
    return {-normal.y, normal.x};
}

}  // namespace dem
