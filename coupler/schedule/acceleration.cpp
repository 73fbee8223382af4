#include "coupler/schedule/acceleration.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <unordered_map>
#include <utility>

#include "coupler/base/error.hpp"
#include "coupler/schedule/joint_step.hpp"

namespace sluice {

namespace {

using Vector = std::vector<double>;
constexpr std::int64_t state_version = 1;

Eigen::Map<Eigen::VectorXd const> part(Vector const& values, std::size_t first, std::size_t size)
{
    return {values.data() + first, static_cast<Eigen::Index>(size)};
}

Vector difference(Vector const& a, Vector const& b)
{
    Vector d(a.size());
    std::transform(a.begin(), a.end(), b.begin(), d.begin(), std::minus<>());
    return d;
}

//! Reads a state's numbers one after the other; throws when they run out or are not what they must be.
struct StateReader
{
    AccelerationState const& state;
    std::size_t number = 0, value = 0;

    static void check(bool ok)
    {
        require(ok, [] {
            return Error(
                "implicit coupling: a saved state that does not fit (needs the columns of this edge). "
                "Restart from a checkpoint of the same scene.",
                Exit::io);
        });
    }
    std::int64_t integer(std::int64_t least, std::int64_t most)
    {
        check(number < state.numbers.size());
        std::int64_t const n = state.numbers[number++];
        check(n >= least && n <= most);
        return n;
    }
    Vector vector(std::size_t size)
    {
        check(state.values.size() - value >= size);
        auto const begin = state.values.begin() + static_cast<std::ptrdiff_t>(value);
        value += size;
        return Vector(begin, begin + static_cast<std::ptrdiff_t>(size));
    }
};

}  // namespace

AccelerationBlock::AccelerationBlock(AccelerationConfig config, int number, std::vector<Column> columns)
    : config_(std::move(config)), number_(number), columns_(std::move(columns)), relaxation_(config_.relaxation)
{
    for ([[maybe_unused]] Column const& c : columns_)
        assert(c.components > 0 && c.joint >= 0 && static_cast<std::size_t>(c.joint) < config_.columns.size());
}

std::size_t AccelerationBlock::width() const
{
    std::size_t numbers = 0;
    for (Column const& c : columns_) numbers += static_cast<std::size_t>(c.components);
    return numbers;
}

Vector AccelerationBlock::joined(Columns const& columns) const
{
    assert(columns.size() == columns_.size());
    Vector all;
    all.reserve(ids_.size() * width());
    for (Vector const& column : columns) all.insert(all.end(), column.begin(), column.end());
    assert(all.size() == ids_.size() * width());
    return all;
}

void AccelerationBlock::check_finite(Columns const& columns, char const* what) const
{
    for (std::size_t c = 0; c < columns_.size(); ++c)
        for (std::size_t i = 0; i < columns[c].size(); ++i)
            require(std::isfinite(columns[c][i]), [&] {
                return Error("implicit coupling: " + config_.columns[static_cast<std::size_t>(columns_[c].joint)].name +
                                 " of point " +
                                 std::to_string(ids_[i / static_cast<std::size_t>(columns_[c].components)]) + " is " +
                                 std::to_string(columns[c][i]) + " as " + what +
                                 " (must be finite). Try a shorter window or a smaller relaxation.",
                             Exit::numerical);
            });
}

//! Moves the numbers of each point to its new place: source[p] is its old one, -1 for a new point.
void AccelerationBlock::move_to(Vector& values, std::vector<std::int64_t> const& source) const
{
    Vector moved(source.size() * width(), 0.0);
    std::size_t from = 0, to = 0;
    for (Column const& column : columns_) {
        auto const n = static_cast<std::size_t>(column.components);
        for (std::size_t p = 0; p < source.size(); ++p)
            if (source[p] >= 0)
                for (std::size_t k = 0; k < n; ++k)
                    moved[to + p * n + k] = values[from + static_cast<std::size_t>(source[p]) * n + k];
        from += ids_.size() * n;
        to += source.size() * n;
    }
    values = std::move(moved);
}

void AccelerationBlock::begin_window(std::span<std::int64_t const> ids)
{
    iteration_ = 0;
    if (std::equal(ids.begin(), ids.end(), ids_.begin(), ids_.end())) return;
    std::unordered_map<std::int64_t, std::int64_t> place;
    for (std::size_t p = 0; p < ids_.size(); ++p) place[ids_[p]] = static_cast<std::int64_t>(p);
    std::vector<std::int64_t> source;
    source.reserve(ids.size());
    for (std::int64_t const id : ids) {
        auto const old = place.find(id);
        source.push_back(old == place.end() ? -1 : old->second);
    }
    for (Difference& d : differences_) {
        move_to(d.residual, source);
        move_to(d.result, source);
    }
    ids_.assign(ids.begin(), ids.end());
}

void AccelerationBlock::remember_difference()
{
    differences_.insert(differences_.begin(),
                        {window_, difference(residual_, last_residual_), difference(result_, last_result_)});
    if (differences_.size() > most_differences) differences_.pop_back();
}

//! R of [V | r] over the rows first .. first + size - 1: Householder QR, whole rows of the upper trapezoid.
Vector AccelerationBlock::factor_of(std::size_t first, std::size_t size) const
{
    auto const wide = static_cast<Eigen::Index>(differences_.size()) + 1;
    auto const tall = static_cast<Eigen::Index>(size);
    if (wide == 1 || tall == 0) return {};
    Eigen::MatrixXd matrix(tall, wide);
    for (std::size_t j = 0; j < differences_.size(); ++j)
        matrix.col(static_cast<Eigen::Index>(j)) = part(differences_[j].residual, first, size);
    matrix.col(wide - 1) = part(residual_, first, size);
    Eigen::HouseholderQR<Eigen::Ref<Eigen::MatrixXd>> const qr(matrix);  // in place
    Vector factor;
    for (Eigen::Index row = 0; row < std::min(tall, wide); ++row)
        for (Eigen::Index j = row; j < wide; ++j) factor.push_back(matrix(row, j));
    return factor;
}

std::vector<double> AccelerationBlock::summary(Columns const& used, Columns const& result)
{
    check_finite(used, "used");
    check_finite(result, "result");
    last_result_ = std::move(result_);
    last_residual_ = std::move(residual_);
    used_ = joined(used);
    result_ = joined(result);
    residual_ = difference(result_, used_);
    if (config_.method == AccelerationConfig::Method::iqn_ils && iteration_ > 0) remember_difference();

    Summary s{.method = static_cast<int>(config_.method),
              .block = number_,
              .iteration = iteration_,
              .differences = static_cast<int>(differences_.size()),
              .columns = std::vector<ColumnSummary>(config_.columns.size())};
    std::size_t first = 0;
    for (Column const& column : columns_) {
        std::size_t const size = ids_.size() * static_cast<std::size_t>(column.components);
        auto const r = part(residual_, first, size);
        ColumnSummary& c = s.columns[static_cast<std::size_t>(column.joint)];
        c.used = part(used_, first, size).squaredNorm();
        c.result = part(result_, first, size).squaredNorm();
        c.residual = r.squaredNorm();
        if (iteration_ > 0) {
            auto const last = part(last_residual_, first, size);
            c.change = (r - last).squaredNorm();
            c.overlap = last.dot(r - last);
        }
        c.factor = factor_of(first, size);
        first += size;
    }
    ++iteration_;
    return pack(s);
}

AccelerationStep AccelerationBlock::next(std::span<std::vector<double> const> summaries, Columns& next_input)
{
    assert(iteration_ > 0);
    AccelerationStep const step = joint_step(config_, unpack(config_, summaries), relaxation_);
    Vector x;
    if (step.relaxation != 0) {
        if (config_.method == AccelerationConfig::Method::aitken) relaxation_ = step.relaxation;
        x = used_;
        for (std::size_t i = 0; i < x.size(); ++i) x[i] += step.relaxation * residual_[i];
    } else {
        x = result_;
        for (std::size_t const j : step.kept)
            for (std::size_t i = 0; i < x.size(); ++i) x[i] += step.coefficients[j] * differences_[j].result[i];
    }
    std::vector<Difference> kept;
    for (std::size_t const j : step.kept) kept.push_back(std::move(differences_[j]));
    differences_ = std::move(kept);

    next_input.resize(columns_.size());
    auto from = x.begin();
    for (std::size_t c = 0; c < columns_.size(); ++c) {
        auto const size = static_cast<std::ptrdiff_t>(ids_.size()) * columns_[c].components;
        next_input[c].assign(from, from + size);
        from += size;
    }
    return step;
}

void AccelerationBlock::accept()
{
    ++window_;
    iteration_ = 0;
    std::erase_if(differences_, [&](Difference const& d) { return d.window < window_ - config_.history; });
}

AccelerationState AccelerationBlock::save() const
{
    assert(iteration_ == 0);
    AccelerationState state;
    auto& n = state.numbers;
    auto& v = state.values;
    n = {state_version, window_, static_cast<std::int64_t>(columns_.size())};
    for (Column const& c : columns_) n.insert(n.end(), {c.joint, c.components});
    n.push_back(static_cast<std::int64_t>(ids_.size()));
    n.insert(n.end(), ids_.begin(), ids_.end());
    n.push_back(static_cast<std::int64_t>(differences_.size()));
    v.push_back(relaxation_);
    for (Difference const& d : differences_) {
        n.push_back(d.window);
        v.insert(v.end(), d.residual.begin(), d.residual.end());
        v.insert(v.end(), d.result.begin(), d.result.end());
    }
    return state;
}

void AccelerationBlock::restore(AccelerationState const& state)
{
    constexpr std::int64_t any = INT64_MAX;
    StateReader reader{state};
    reader.integer(state_version, state_version);
    std::int64_t const window = reader.integer(0, any);
    auto const count = static_cast<std::int64_t>(columns_.size());
    reader.integer(count, count);
    for (Column const& c : columns_) {
        reader.integer(c.joint, c.joint);
        reader.integer(c.components, c.components);
    }
    auto const points = reader.integer(0, static_cast<std::int64_t>(state.numbers.size()));
    std::vector<std::int64_t> ids;
    for (std::int64_t p = 0; p < points; ++p) ids.push_back(reader.integer(INT64_MIN, any));
    auto const differences = reader.integer(0, static_cast<std::int64_t>(most_differences));
    double const relaxation = reader.vector(1)[0];
    std::vector<Difference> restored;
    std::size_t const size = ids.size() * width();
    for (std::int64_t d = 0; d < differences; ++d) {
        std::int64_t const made = reader.integer(0, window);
        Vector residual = reader.vector(size);
        restored.push_back({made, std::move(residual), reader.vector(size)});
    }
    StateReader::check(reader.number == state.numbers.size() && reader.value == state.values.size());
    window_ = window;
    iteration_ = 0;
    relaxation_ = relaxation;
    ids_ = std::move(ids);
    differences_ = std::move(restored);
}

}  // namespace sluice
