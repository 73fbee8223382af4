#pragma once

#include <cmath>
#include <cstring>
#include <functional>
#include <numeric>
#include <random>
#include <vector>

#include "coupler/schedule/acceleration.hpp"

//! A group that looks for x = H(x), its unknowns shared out among receivers: what the coupler does, in one process.
namespace fixed_point {

using Vector = std::vector<double>;
using Map = std::function<Vector(Vector const&)>;
using Columns = sluice::AccelerationBlock::Columns;

inline double norm(Vector const& v)
{
    return std::sqrt(std::inner_product(v.begin(), v.end(), v.begin(), 0.0));
}

inline double distance(Vector const& a, Vector const& b)
{
    Vector d(a.size());
    for (std::size_t i = 0; i < a.size(); ++i) d[i] = a[i] - b[i];
    return norm(d);
}

inline bool same_bits(Vector const& a, Vector const& b)
{
    return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0);
}

struct Outcome
{
    bool converged = false;
    int evaluations = 0;         //!< of H, until judged converged
    Vector x;                    //!< the last input
    std::vector<Vector> inputs;  //!< of every evaluation
    bool agreed = true;          //!< every block took the same step, bit for bit
    std::size_t kept = 0;        //!< differences that passed the last step's filter
};

//! Joint columns of one number per point, `points` each: the joint vector is column after column.
class Group
{
 public:
    Group(sluice::AccelerationConfig const& config, std::size_t points, std::size_t blocks)
        : config_(config), points_(points)
    {
        std::vector<sluice::AccelerationBlock::Column> columns;
        for (std::size_t c = 0; c < config.columns.size(); ++c) columns.push_back({static_cast<int>(c), 1});
        for (std::size_t b = 0; b < blocks; ++b) {
            blocks_.emplace_back(config, static_cast<int>(b), columns);
            first_.push_back(b * points / blocks);
        }
        first_.push_back(points);
    }

    //! One window, from x. Gives up after `most` evaluations.
    Outcome window(Map const& h, Vector x, int most)
    {
        Outcome outcome;
        for (std::size_t b = 0; b < blocks_.size(); ++b) {
            std::vector<std::int64_t> ids(first_[b + 1] - first_[b]);
            std::iota(ids.begin(), ids.end(), static_cast<std::int64_t>(first_[b]));
            blocks_[b].begin_window(ids);
        }
        while (!outcome.converged && outcome.evaluations < most) {
            outcome.inputs.push_back(x);
            Vector const result = h(x);
            ++outcome.evaluations;
            std::vector<Vector> summaries;
            for (std::size_t b = 0; b < blocks_.size(); ++b)
                summaries.push_back(blocks_[b].summary(part(x, b), part(result, b)));
            outcome.converged = sluice::judge(config_, summaries).converged;
            outcome.x = x;
            if (!outcome.converged) step(summaries, x, outcome);
        }
        for (auto& block : blocks_) block.accept();
        return outcome;
    }

 private:
    void step(std::vector<Vector> const& summaries, Vector& x, Outcome& outcome)
    {
        sluice::AccelerationStep first;
        for (std::size_t b = 0; b < blocks_.size(); ++b) {
            Columns next;
            auto const taken = blocks_[b].next(summaries, next);
            if (b == 0) first = taken;
            outcome.agreed = outcome.agreed && same_bits(taken.coefficients, first.coefficients) &&
                             same_bits({taken.relaxation}, {first.relaxation}) && taken.kept == first.kept;
            for (std::size_t c = 0; c < next.size(); ++c)
                std::copy(next[c].begin(), next[c].end(),
                          x.begin() + static_cast<std::ptrdiff_t>(c * points_ + first_[b]));
        }
        outcome.kept = first.kept.size();
    }

    Columns part(Vector const& x, std::size_t block) const
    {
        Columns columns;
        for (std::size_t c = 0; c < config_.columns.size(); ++c) {
            auto const begin = x.begin() + static_cast<std::ptrdiff_t>(c * points_);
            columns.emplace_back(begin + static_cast<std::ptrdiff_t>(first_[block]),
                                 begin + static_cast<std::ptrdiff_t>(first_[block + 1]));
        }
        return columns;
    }

    sluice::AccelerationConfig config_;
    std::size_t points_;
    std::vector<sluice::AccelerationBlock> blocks_;
    std::vector<std::size_t> first_;  //!< first point of each block, and the end
};

//! H(x) = x* + A (x - x*), so that x* is known.
struct Linear
{
    std::vector<Vector> rows;  //!< A
    Vector solution;           //!< x*

    Vector operator()(Vector const& x) const
    {
        Vector y = solution;
        for (std::size_t i = 0; i < x.size(); ++i)
            for (std::size_t j = 0; j < x.size(); ++j) y[i] += rows[i][j] * (x[j] - solution[j]);
        return y;
    }
};

inline Vector random_vector(std::size_t n, std::mt19937& random)
{
    std::uniform_real_distribution<double> uniform(-1, 1);
    Vector v(n);
    for (double& x : v) x = uniform(random);
    return v;
}

//! A = -diag(`diagonal`) + `coupling` times random numbers in (-1, 1), and a random solution.
inline Linear linear_problem(Vector const& diagonal, double coupling, std::mt19937& random)
{
    Linear problem;
    for (std::size_t i = 0; i < diagonal.size(); ++i) {
        problem.rows.push_back(random_vector(diagonal.size(), random));
        for (double& a : problem.rows.back()) a *= coupling;
        problem.rows.back()[i] -= diagonal[i];
    }
    problem.solution = random_vector(diagonal.size(), random);
    return problem;
}

}  // namespace fixed_point
