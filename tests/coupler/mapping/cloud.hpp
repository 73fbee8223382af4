#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "coupler/mapping/mapping.hpp"

//! Point sets and sums that the mapping tests share. All random numbers are seeded: a failure repeats.
namespace sluice::test {

using Values = std::vector<double>;

struct Cloud
{
    int dimension = 3;
    Values position;
    std::size_t size() const { return position.size() / static_cast<std::size_t>(dimension); }
    double at(std::size_t i, int k) const
    {
        return position[i * static_cast<std::size_t>(dimension) + static_cast<std::size_t>(k)];
    }
    operator Points() const { return {position, dimension}; }
};

inline Values random_values(std::size_t count, unsigned seed, double low = -1, double high = 1)
{
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> uniform(low, high);
    Values values(count);
    for (double& v : values) v = uniform(random);
    return values;
}

inline Cloud uniform(int dimension, std::size_t count, unsigned seed, double low = 0, double high = 1)
{
    return {dimension, random_values(count * static_cast<std::size_t>(dimension), seed, low, high)};
}

//! n^d points of a lattice over the unit box, each moved by up to `jitter` spacings.
inline Cloud grid(int dimension, int n, double jitter, unsigned seed)
{
    auto const count = static_cast<std::size_t>(std::pow(n, dimension) + 0.5);
    Cloud cloud = uniform(dimension, count, seed, -jitter, jitter);
    for (std::size_t i = 0; i < count; ++i) {
        auto rest = static_cast<int>(i);
        for (int k = 0; k < dimension; ++k, rest /= n) {
            double& x = cloud.position[i * static_cast<std::size_t>(dimension) + static_cast<std::size_t>(k)];
            x = (x + rest % n + 0.5) / n;
        }
    }
    return cloud;
}

inline Cloud changed(Cloud cloud, std::function<void(double*)> const& change)
{
    for (std::size_t i = 0; i < cloud.size(); ++i)
        change(cloud.position.data() + i * static_cast<std::size_t>(cloud.dimension));
    return cloud;
}

inline Cloud joined(Cloud a, Cloud const& b)
{
    a.position.insert(a.position.end(), b.position.begin(), b.position.end());
    return a;
}

inline double dot(Values const& a, Values const& b)
{
    return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
}

inline double norm(Values const& a)
{
    return std::sqrt(dot(a, a));
}

//! Sum over the points of component c; `absolute`: of its magnitude.
inline double sum(Values const& v, std::size_t width, std::size_t c, bool absolute = false)
{
    double total = 0;
    for (std::size_t i = c; i < v.size(); i += width) total += absolute ? std::abs(v[i]) : v[i];
    return total;
}

//! Sum over the points of (x_k - origin_k) v_c: the first moments, of which torque is made.
inline double moment(Cloud const& cloud, Values const& v, std::size_t width, std::size_t c, int k, double origin)
{
    double total = 0;
    for (std::size_t i = 0; i < cloud.size(); ++i) total += (cloud.at(i, k) - origin) * v[i * width + c];
    return total;
}

inline Values sampled(Cloud const& cloud, std::function<double(double const*)> const& field)
{
    Values values;
    for (std::size_t i = 0; i < cloud.size(); ++i)
        values.push_back(field(cloud.position.data() + i * static_cast<std::size_t>(cloud.dimension)));
    return values;
}

inline double rms_difference(Values const& a, Values const& b)
{
    double square = 0;
    for (std::size_t i = 0; i < a.size(); ++i) square += (a[i] - b[i]) * (a[i] - b[i]);
    return std::sqrt(square / static_cast<double>(a.size()));
}

inline double max_difference(Values const& a, Values const& b)
{
    double most = 0;
    for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, std::abs(a[i] - b[i]));
    return most;
}

//! Least-squares slope of log error over log spacing.
inline double order(Values const& spacing, Values const& error)
{
    double sx = 0, sy = 0, sxx = 0, sxy = 0;
    auto const n = static_cast<double>(spacing.size());
    for (std::size_t i = 0; i < spacing.size(); ++i) {
        double const x = std::log(spacing[i]), y = std::log(error[i]);
        sx += x, sy += y, sxx += x * x, sxy += x * y;
    }
    return (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

//! A smooth field with curvature in every direction; x has 2 or 3 numbers.
inline double wave(double const* x, int dimension)
{
    return std::sin(2 * x[0] + 0.3) * std::cos(3 * x[1]) * (dimension == 3 ? std::exp(0.7 * x[2]) : 1.0);
}

//! The mappings by place, each to be held to the same rules.
struct Method
{
    std::string name;
    std::function<Mapping(Points, Points)> build;
    bool linear_exact;  //!< and so keeps first moments
};

inline std::vector<Method> methods(double radius = 0.3)
{
    return {{"nearest", [](Points a, Points b) { return map_nearest(a, b); }, false},
            {"kernel", [radius](Points a, Points b) { return map_kernel(a, b, radius); }, false},
            {"linear", [](Points a, Points b) { return map_linear(a, b); }, true},
            {"rbf", [](Points a, Points b) { return map_rbf(a, b); }, true}};
}

}  // namespace sluice::test
