#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

//! How something moves that nothing holds up: a wall. For any type of vector with +, a number times it, and ==.
namespace motion {

template <class Vector>
Vector zero()
{
    if constexpr (requires { Vector::Zero(); })
        return Vector::Zero();
    else
        return {};
}

//! A velocity at a time.
template <class Vector>
struct Knot
{
    double time = 0.0;                 //!< [s]
    Vector velocity = zero<Vector>();  //!< [m/s]
};

//! A displacement over time:  from `begin` to `end` at `velocity`, and `amplitude` sin(2 pi f (t - begin)); and by a
//! velocity that goes straight from knot to knot, none before the first and behind the last.
template <class Vector>
struct PrescribedMotion
{
    Vector velocity = zero<Vector>();                      //!< [m/s]
    Vector amplitude = zero<Vector>();                     //!< [m]
    double frequency = 0.0;                                //!< [Hz]
    double begin = 0.0;                                    //!< [s]
    double end = std::numeric_limits<double>::infinity();  //!< [s]; it then stays where it is

    std::vector<Knot<Vector>> knots;  //!< times ascending

    bool moves() const noexcept
    {
        return !(velocity == zero<Vector>() && amplitude == zero<Vector>() && knots.empty());
    }

    Vector shift(double time) const noexcept
    {
        double const since = std::min(std::max(time, begin), end) - begin;
        Vector sum = since * velocity + std::sin(2.0 * std::numbers::pi * frequency * since) * amplitude;
        for (std::size_t k = 1; k < knots.size() && knots[k - 1].time < time; ++k) {
            double const until = std::min(time, knots[k].time);
            sum = sum + 0.5 * (until - knots[k - 1].time) * (knots[k - 1].velocity + between(k, until));
        }
        return sum;
    }
    Vector speed(double time) const noexcept
    {
        Vector sum = zero<Vector>();
        if (time >= begin && time <= end) {
            double const turns = 2.0 * std::numbers::pi * frequency;
            sum = velocity + turns * std::cos(turns * (time - begin)) * amplitude;
        }
        for (std::size_t k = 1; k < knots.size(); ++k)
            if (time >= knots[k - 1].time && time < knots[k].time) return sum + between(k, time);
        return sum;
    }

 private:
    //! The velocity at a time between knots k - 1 and k.
    Vector between(std::size_t k, double time) const noexcept
    {
        Knot<Vector> const &a = knots[k - 1], &b = knots[k];
        return a.velocity + (time - a.time) / (b.time - a.time) * (b.velocity - a.velocity);
    }
};

//! The same with another type of vector: `to(vector)`.
template <class To, class From, class Convert>
PrescribedMotion<To> converted(PrescribedMotion<From> const& m, Convert&& to)
{
    PrescribedMotion<To> out{to(m.velocity), to(m.amplitude), m.frequency, m.begin, m.end, {}};
    for (auto const& [time, velocity] : m.knots) out.knots.push_back({time, to(velocity)});
    return out;
}

}  // namespace motion
