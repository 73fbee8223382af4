#pragma once

#include <cstddef>
#include <utility>

#include "coupler/scene/reader.hpp"
#include "participants/motion/prescribed_motion.hpp"

namespace motion {

//! The keys of a wall's motion (README.md). `vector(numbers)`: of `dimension` numbers makes one of its type.
template <class Convert>
auto read_motion(sluice::Reader& r, std::size_t dimension, Convert&& vector)
{
    using Vector = decltype(vector(std::vector<double>{}));
    sluice::Bounds const lengths{.min = -1e6, .max = 1e6, .unit = "m"};
    sluice::Bounds const speeds{.min = -1e3, .max = 1e3, .unit = "m/s"};
    PrescribedMotion<Vector> m;
    m.velocity = vector(r.numbers_or("velocity", std::vector<double>(dimension, 0.0), speeds));
    if (auto swing = r.child_if("oscillation")) {
        m.amplitude = vector(swing->numbers("amplitude", dimension, lengths));
        m.frequency = swing->number("frequency", {.above = 0.0, .max = 1e6, .unit = "Hz"});
        swing->finish();
    }
    for (auto& knot : r.list("velocities")) {
        m.knots.push_back(
            {knot.number("at", {.min = 0.0, .unit = "s"}), vector(knot.numbers("velocity", dimension, speeds))});
        if (m.knots.size() > 1 && !(m.knots.back().time > m.knots[m.knots.size() - 2].time))
            knot.refuse("at", "is not after the one before (times must ascend).");
        knot.finish();
    }
    if (m.knots.size() == 1) r.problem("velocities", "has one entry (needs two: from where, to where).");
    if (!m.moves()) return m;
    m.begin = r.number_or("moves_from", 0.0, {.min = 0.0, .unit = "s"});
    if (auto const end = r.number_if("moves_until", {.min = m.begin, .unit = "s"})) m.end = *end;
    return m;
}

}  // namespace motion
