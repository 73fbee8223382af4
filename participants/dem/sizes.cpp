#include "participants/dem/sizes.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace dem {
namespace {

//! Integral of x^(power - 1) from low to high.
double integral(double low, double high, double power)
{
    if (std::abs(power) < 1e-12) return std::log(high / low);
    return (std::pow(high, power) - std::pow(low, power)) / power;
}

}  // namespace

Sizes Sizes::uniform_number(double low, double high)
{
    Sizes sizes;
    sizes.pieces_ = {{low, high, -1.0, 1.0}};
    return sizes;
}

Sizes Sizes::fractal(double low, double high, double exponent)
{
    Sizes sizes;
    sizes.kind_ = Kind::pieces;
    sizes.pieces_ = {{low, high, exponent, 1.0}};
    return sizes;
}

Sizes Sizes::uniform_mass(double low, double high, int dimension)
{
    return fractal(low, high, dimension - 1.0);  // the density by number goes with d^-dimension
}

Sizes Sizes::lognormal(double mean, double deviation, double low, double high)
{
    Sizes sizes;
    sizes.kind_ = Kind::lognormal;
    sizes.pieces_ = {{low, high, 0.0, 1.0}};
    double const spread = deviation / mean, variance = std::log1p(spread * spread);
    sizes.log_mean_ = std::log(mean) - 0.5 * variance;
    sizes.log_deviation_ = std::sqrt(variance);
    return sizes;
}

Sizes Sizes::grading(std::vector<std::pair<double, double>> const& curve, int dimension)
{
    // straight in ln d: the density of mass goes with 1/d, that of number with d^-(dimension + 1)
    Sizes sizes;
    sizes.kind_ = Kind::pieces;
    sizes.pieces_.clear();
    double all = 0.0;
    for (std::size_t k = 0; k + 1 < curve.size(); ++k) {
        auto const& [low, finer] = curve[k];
        auto const& [high, next] = curve[k + 1];
        double const weight = (next - finer) / std::log(high / low) * integral(low, high, -dimension);
        sizes.pieces_.push_back({low, high, static_cast<double>(dimension), weight});
        all += weight;
    }
    for (Piece& piece : sizes.pieces_) piece.weight /= all;
    return sizes;
}

//! Part of the normal law below ln d, its mean moved up by `shift` deviations.
double Sizes::normal(double diameter, double shift) const
{
    return 0.5 * std::erfc(-((std::log(diameter) - log_mean_) / log_deviation_ - shift) / std::sqrt(2.0));
}

double Sizes::kept() const
{
    return normal(high()) - normal(low());
}

double Sizes::draw(Random& random) const
{
    if (kind_ == Kind::uniform) return random.uniform(low(), high());
    double u = random.uniform();
    if (kind_ == Kind::lognormal) {
        double below = low(), above = high();
        while (above - below > 1e-12 * above) {
            double const middle = 0.5 * (below + above);
            (finer(middle) < u ? below : above) = middle;
        }
        return 0.5 * (below + above);
    }
    auto piece = pieces_.begin();
    while (std::next(piece) != pieces_.end() && u >= piece->weight) u -= (piece++)->weight;
    u /= piece->weight;
    double const e = -piece->exponent;
    if (std::abs(e) < 1e-12) return piece->low * std::pow(piece->high / piece->low, u);
    double const from = std::pow(piece->low, e), to = std::pow(piece->high, e);
    return std::min(piece->high, std::max(piece->low, std::pow(from + u * (to - from), 1.0 / e)));
}

double Sizes::finer(double diameter) const
{
    if (diameter <= low()) return 0.0;
    if (diameter >= high()) return 1.0;
    if (kind_ == Kind::lognormal) return (normal(diameter) - normal(low())) / kept();
    double sum = 0.0;
    for (Piece const& p : pieces_) {
        if (diameter >= p.high)
            sum += p.weight;
        else if (diameter > p.low)
            sum += p.weight * integral(p.low, diameter, -p.exponent) / integral(p.low, p.high, -p.exponent);
    }
    return sum;
}

double Sizes::moment(int power) const
{
    double const a = low(), b = high();
    if (kind_ == Kind::uniform && power == 1) return 0.5 * (a + b);
    if (kind_ == Kind::uniform && power == 2) return (a * a + a * b + b * b) / 3.0;
    if (kind_ == Kind::uniform && power == 3) return (a + b) * (a * a + b * b) / 4.0;
    if (kind_ == Kind::lognormal) {
        double const shift = power * log_deviation_;
        return std::exp(power * log_mean_ + 0.5 * shift * shift) * (normal(b, shift) - normal(a, shift)) / kept();
    }
    double sum = 0.0;
    for (Piece const& p : pieces_)
        sum += p.high > p.low
                   ? p.weight * integral(p.low, p.high, power - p.exponent) / integral(p.low, p.high, -p.exponent)
                   : p.weight * std::pow(p.low, power);
    return sum;
}

std::vector<double> Sizes::numbers() const
{
    std::vector<double> all{static_cast<double>(kind_), log_mean_, log_deviation_};
    for (Piece const& p : pieces_) all.insert(all.end(), {p.low, p.high, p.exponent, p.weight});
    return all;
}

}  // namespace dem
