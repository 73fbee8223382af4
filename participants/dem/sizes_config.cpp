#include "coupler/base/format.hpp"
#include "participants/dem/config_parts.hpp"

namespace dem {
namespace {

using sluice::Reader;

constexpr sluice::Bounds lengths{.above = 1e-9, .max = 1e3, .unit = "m"};

void check_range(Reader& r, char const* key, double low, double high)
{
    if (high < low) r.problem(key, sluice::format("%g m is below min = %g m (must be at least min).", high, low));
    if (high > 50.0 * low)
        r.problem(
            key, sluice::format("%g m is more than 50 times min = %g m (a step for the smallest would take the largest "
                                "nowhere).",
                                high, low));
}

//! Points {diameter, finer}, both ascending, from 0 to 1.
Sizes read_grading(Reader& r, Config const& config)
{
    std::vector<std::pair<double, double>> curve;
    for (Reader point : r.list("grading")) {
        double const diameter = point.number("diameter", lengths);
        double const finer = point.number("finer", {.min = 0.0, .max = 1.0});
        if (!curve.empty() && diameter <= curve.back().first)
            point.problem("diameter", sluice::format("%g m is not above the point before, %g m (must ascend).",
                                                     diameter, curve.back().first));
        if (!curve.empty() && finer < curve.back().second)
            point.problem("finer", sluice::format("%g is below the point before, %g (must not fall).", finer,
                                                  curve.back().second));
        point.finish();
        curve.emplace_back(diameter, finer);
    }
    bool const whole = curve.size() >= 2 && curve.front().second == 0.0 && curve.back().second == 1.0;
    if (!whole) r.problem("grading", "must be two points or more, from finer: 0 to finer: 1.");
    if (!whole || !r.diagnostics()->problems.empty()) return config.sizes;
    check_range(r, "grading", curve.front().first, curve.back().first);
    return Sizes::grading(curve, config.dimension);
}

Sizes read_lognormal(Reader& r, double low, double high)
{
    double const mean = r.number("mean", lengths), deviation = r.number("deviation", lengths);
    if (!r.diagnostics()->problems.empty()) return {};
    Sizes const sizes = Sizes::lognormal(mean, deviation, low, high);
    if (low == high || !(sizes.kept() >= 0.01))
        r.problem("mean", sluice::format(
                              "%g m, deviation %g m: less than a hundredth of this law lies from min to max (must be "
                              "more). Move min or max.",
                              mean, deviation));
    return sizes;
}

}  // namespace

void read_diameter(Reader r, Config& config)
{
    if (r.has("grading")) {
        config.sizes = read_grading(r, config);
        config.diameter_min = config.sizes.low();
        config.diameter_max = config.sizes.high();
        r.finish();
        return;
    }
    double const low = r.number("min", lengths), high = r.number("max", lengths);
    check_range(r, "max", low, high);
    config.diameter_min = low;
    config.diameter_max = high;
    config.sizes = Sizes::uniform_number(low, high);
    switch (r.choice_or("law", 0, {"uniform_number", "uniform_mass", "lognormal", "fractal"})) {
        case 1:
            config.sizes = Sizes::uniform_mass(low, high, config.dimension);
            break;
        case 2:
            config.sizes = read_lognormal(r, low, high);
            break;
        case 3:
            config.sizes = Sizes::fractal(low, high, r.number("fractal_dimension", {.min = -10.0, .max = 10.0}));
            break;
        default:
            break;
    }
    r.finish();
}

}  // namespace dem
