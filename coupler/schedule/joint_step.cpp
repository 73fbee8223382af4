#include "coupler/schedule/joint_step.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "coupler/base/error.hpp"

namespace sluice {

namespace {

using Vector = std::vector<double>;

//! QR2 filter: a difference whose part orthogonal to all newer ones is shorter than this share of it is dropped.
//! preCICE advises 1e-3 to 1e-2.
constexpr double filter_limit = 1e-3;
//! A difference shorter than this, relative to the values themselves, is dropped too: the rounding in it, some 1e-15 of
//! the values, would pass the filter as a direction of its own.
constexpr double noise = 1e-15 / filter_limit;
constexpr std::size_t header = 5, column_header = 6;

double squared(double x)
{
    return x * x;
}

//! Four sums, so that the processor may overlap them; their order is fixed by this text.
double dot(Vector const& a, Vector const& b)
{
    double sum[4] = {0, 0, 0, 0};
    std::size_t i = 0;
    for (; i + 4 <= a.size(); i += 4)
        for (std::size_t lane = 0; lane < 4; ++lane) sum[lane] += a[i + lane] * b[i + lane];
    for (; i < a.size(); ++i) sum[0] += a[i] * b[i];
    return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

void subtract(Vector& from, double factor, Vector const& direction)
{
    for (std::size_t i = 0; i < from.size(); ++i) from[i] -= factor * direction[i];
}

//! Calls see(row, column, value) for every number of the factor.
template <class See>
void for_factor(ColumnSummary const& summary, int differences, See&& see)
{
    auto const wide = static_cast<std::size_t>(differences) + 1;
    std::size_t at = 0;
    for (std::size_t row = 0; at < summary.factor.size(); ++row)
        for (std::size_t j = row; j < wide; ++j) see(row, j, summary.factor[at++]);
}

std::size_t factor_rows(ColumnSummary const& summary, int differences)
{
    std::size_t rows = 0;
    for_factor(summary, differences, [&](std::size_t row, std::size_t, double) { rows = row + 1; });
    return rows;
}

[[noreturn]] void mismatch(std::string const& seen)
{
    throw Error("implicit coupling: " + seen + " (all members must be in the same iteration of the same group). " +
                    "Run one version of the program everywhere.",
                Exit::protocol);
}

//! Numbers of a factor with `rows` rows, or nothing if there cannot be that many.
std::size_t factor_size(double rows, int differences)
{
    if (!(rows >= 0 && rows <= differences + 1 && rows == std::floor(rows))) mismatch("a summary of odd shape");
    auto const whole = static_cast<std::size_t>(rows);
    return whole * (static_cast<std::size_t>(differences) + 1) - (whole > 0 ? whole * (whole - 1) / 2 : 0);
}

int small_number(double x)
{
    if (!(x >= 0 && x <= 1e9 && x == std::floor(x))) mismatch("a summary whose header is not a count");
    return static_cast<int>(x);
}

Summary unpack_one(AccelerationConfig const& config, Vector const& packed)
{
    if (packed.size() < header) mismatch("a summary of " + std::to_string(packed.size()) + " numbers");
    Summary s;
    s.method = small_number(packed[0]);
    s.block = small_number(packed[1]);
    s.iteration = small_number(packed[2]);
    s.differences = small_number(packed[3]);
    if (packed[4] != static_cast<double>(config.columns.size())) mismatch("a summary of other columns");
    if (s.differences > static_cast<int>(most_differences)) mismatch("a summary of too many differences");
    std::size_t at = header;
    for (std::size_t c = 0; c < config.columns.size(); ++c) {
        if (packed.size() - at < column_header) mismatch("a summary that is cut off");
        double const* p = packed.data() + at;
        ColumnSummary column{p[0], p[1], p[2], p[3], p[4], {}};
        std::size_t const size = factor_size(p[5], s.differences);
        at += column_header;
        if (packed.size() - at < size) mismatch("a summary that is cut off");
        column.factor.assign(packed.begin() + static_cast<std::ptrdiff_t>(at),
                             packed.begin() + static_cast<std::ptrdiff_t>(at + size));
        at += size;
        s.columns.push_back(std::move(column));
    }
    if (at != packed.size()) mismatch("a summary with numbers left over");
    return s;
}

//! The sum over all blocks of one number of a column.
double joint(std::vector<Summary> const& blocks, std::size_t column, double ColumnSummary::*member)
{
    double sum = 0;
    for (Summary const& block : blocks) sum += block.columns[column].*member;
    return sum;
}

//! The square of the largest of |x|, |x~| and the differences' norms: 0 only where everything is.
double scale_squared(std::vector<Summary> const& blocks, std::size_t column)
{
    double scale = std::max(joint(blocks, column, &ColumnSummary::used), joint(blocks, column, &ColumnSummary::result));
    Vector norms(static_cast<std::size_t>(blocks[0].differences) + 1, 0.0);
    for (Summary const& block : blocks)
        for_factor(block.columns[column], block.differences,
                   [&](std::size_t, std::size_t j, double value) { norms[j] += squared(value); });
    for (double const norm : norms) scale = std::max(scale, norm);
    return scale;
}

//! Value weights: each column is measured against itself, so that N and m/s may stand in one vector.
Vector weights(AccelerationConfig const& config, std::vector<Summary> const& blocks)
{
    Vector weight;
    for (std::size_t c = 0; c < config.columns.size(); ++c) {
        double const scale = std::max(std::sqrt(scale_squared(blocks, c)), config.columns[c].floor);
        require(std::isfinite(scale), [&] {
            return Error("implicit coupling: the differences of " + config.columns[c].name +
                             " overflow (must be finite). Try a shorter window or a smaller relaxation.",
                         Exit::numerical);
        });
        weight.push_back(scale > 0 ? 1 / scale : 0);
    }
    return weight;
}

//! Columns of the joint, weighted [V | r], each block's R in place of its rows (TSQR).
std::vector<Vector> stacked(std::vector<Summary> const& blocks, Vector const& weight)
{
    std::size_t const wide = static_cast<std::size_t>(blocks[0].differences) + 1;
    std::size_t rows = 0;
    for (Summary const& block : blocks)
        for (ColumnSummary const& column : block.columns) rows += factor_rows(column, block.differences);
    std::vector<Vector> matrix(wide, Vector(rows, 0.0));
    std::size_t top = 0;
    for (Summary const& block : blocks)
        for (std::size_t c = 0; c < block.columns.size(); ++c) {
            for_factor(block.columns[c], block.differences,
                       [&](std::size_t row, std::size_t j, double value) { matrix[j][top + row] = weight[c] * value; });
            top += factor_rows(block.columns[c], block.differences);
        }
    return matrix;
}

//! QR of the columns that pass the filter, newest first, by modified Gram-Schmidt, the right-hand side treated like one
//! more column: backward stable (Bjorck 1967). In a space of n unknowns the filter passes n columns at most.
struct Factors
{
    std::vector<Vector> q;
    std::vector<Vector> r;          //!< r[k]: coefficients of the k-th kept column in q[0..k]
    std::vector<std::size_t> kept;  //!< index of the k-th kept column

    void add(std::size_t index, Vector column)
    {
        double const before = std::sqrt(dot(column, column));
        if (!(before > noise)) return;
        Vector coefficients(q.size() + 1, 0.0);
        for (std::size_t k = 0; k < q.size(); ++k) {
            coefficients[k] = dot(q[k], column);
            subtract(column, coefficients[k], q[k]);
        }
        double const after = std::sqrt(dot(column, column));
        if (!(after > filter_limit * before)) return;
        for (double& x : column) x /= after;
        coefficients.back() = after;
        q.push_back(std::move(column));
        r.push_back(std::move(coefficients));
        kept.push_back(index);
    }

    //! The c that minimises |sum c_k column_k + rhs|.
    Vector solve(Vector rhs) const
    {
        Vector c(q.size());
        for (std::size_t k = 0; k < q.size(); ++k) {
            c[k] = -dot(q[k], rhs);
            subtract(rhs, -c[k], q[k]);
        }
        for (std::size_t k = q.size(); k-- > 0;) {
            c[k] /= r[k][k];
            for (std::size_t i = 0; i < k; ++i) c[i] -= r[k][i] * c[k];
        }
        return c;
    }
};

double aitken_factor(AccelerationConfig const& config, std::vector<Summary> const& blocks, double last)
{
    if (blocks[0].iteration == 0) return std::copysign(std::min(config.relaxation, std::abs(last)), last);
    Vector const weight = weights(config, blocks);
    double change = 0, overlap = 0;
    for (std::size_t c = 0; c < weight.size(); ++c) {
        change += squared(weight[c]) * joint(blocks, c, &ColumnSummary::change);
        overlap += squared(weight[c]) * joint(blocks, c, &ColumnSummary::overlap);
    }
    if (!(change > squared(noise))) return last;  // nothing moved: nothing to learn
    double const factor = -last * overlap / change;
    return factor == 0 ? config.relaxation : factor;
}

AccelerationStep quasi_newton_step(AccelerationConfig const& config, std::vector<Summary> const& blocks)
{
    auto const differences = static_cast<std::size_t>(blocks[0].differences);
    std::vector<Vector> matrix = stacked(blocks, weights(config, blocks));
    Factors factors;
    for (std::size_t j = 0; j < differences; ++j) factors.add(j, std::move(matrix[j]));
    AccelerationStep step;
    step.coefficients.assign(differences, 0.0);
    step.kept = factors.kept;
    Vector const c = factors.solve(std::move(matrix.back()));
    for (std::size_t k = 0; k < c.size(); ++k) step.coefficients[factors.kept[k]] = c[k];
    if (factors.kept.empty()) step.relaxation = config.relaxation;
    return step;
}

}  // namespace

std::vector<double> pack(Summary const& summary)
{
    Vector packed = {static_cast<double>(summary.method), static_cast<double>(summary.block),
                     static_cast<double>(summary.iteration), static_cast<double>(summary.differences),
                     static_cast<double>(summary.columns.size())};
    for (ColumnSummary const& c : summary.columns) {
        packed.insert(packed.end(), {c.used, c.result, c.residual, c.change, c.overlap,
                                     static_cast<double>(factor_rows(c, summary.differences))});
        packed.insert(packed.end(), c.factor.begin(), c.factor.end());
    }
    return packed;
}

std::vector<Summary> unpack(AccelerationConfig const& config, std::span<std::vector<double> const> packed)
{
    std::vector<Summary> blocks;
    for (Vector const& one : packed) {
        Summary block = unpack_one(config, one);
        if (block.method != static_cast<int>(config.method)) mismatch("a summary for another method");
        if (!blocks.empty()) {
            Summary const& last = blocks.back();
            if (block.block <= last.block) mismatch("summaries that are not in the order of their blocks");
            if (block.iteration != last.iteration || block.differences != last.differences)
                mismatch("block " + std::to_string(block.block) + " in iteration " + std::to_string(block.iteration) +
                         " with " + std::to_string(block.differences) + " differences, block " +
                         std::to_string(last.block) + " in iteration " + std::to_string(last.iteration) + " with " +
                         std::to_string(last.differences));
        }
        blocks.push_back(std::move(block));
    }
    if (blocks.empty()) mismatch("no summary at all");
    return blocks;
}

Verdict judge(AccelerationConfig const& config, std::span<std::vector<double> const> summaries)
{
    std::vector<Summary> const blocks = unpack(config, summaries);
    Verdict verdict{.converged = true, .columns = {}};
    for (std::size_t c = 0; c < config.columns.size(); ++c) {
        AccelerationColumn const& column = config.columns[c];
        ColumnVerdict v{.residual = std::sqrt(joint(blocks, c, &ColumnSummary::residual)),
                        .result = std::sqrt(joint(blocks, c, &ColumnSummary::result))};
        require(std::isfinite(v.residual) && std::isfinite(v.result), [&] {
            return Error("implicit coupling: the norm of " + column.name +
                             " overflows (must be finite). Try a shorter window or a smaller relaxation.",
                         Exit::numerical);
        });
        v.converged = v.residual <= std::max(column.tolerance * v.result, column.floor);
        verdict.converged = verdict.converged && v.converged;
        verdict.columns.push_back(v);
    }
    return verdict;
}

AccelerationStep joint_step(AccelerationConfig const& config, std::vector<Summary> const& blocks,
                            double last_relaxation)
{
    AccelerationStep step;
    switch (config.method) {
        case AccelerationConfig::Method::constant:
            step.relaxation = config.relaxation;
            break;
        case AccelerationConfig::Method::aitken:
            step.relaxation = aitken_factor(config, blocks, last_relaxation);
            break;
        case AccelerationConfig::Method::iqn_ils:
            step = quasi_newton_step(config, blocks);
            break;
    }
    bool finite = std::isfinite(step.relaxation);
    for (double const c : step.coefficients) finite = finite && std::isfinite(c);
    require(finite, [] {
        return Error(
            "implicit coupling: there is no finite next step (must be one). "
            "Try a shorter window, a smaller relaxation or a shorter history.",
            Exit::numerical);
    });
    return step;
}

}  // namespace sluice
