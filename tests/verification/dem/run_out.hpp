#pragma once

#include <cmath>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "coupler/scene/scene.hpp"
#include "participants/dem/setup.hpp"

//! What the cases of run-outs share.
namespace verification {

//! The grains of a scene of configs/, with settings as `--set` has them.
inline dem::Config config_of(std::string const& scene, std::vector<std::string> const& settings)
{
    auto const loaded = sluice::load_scene(std::filesystem::path(CONFIGS) / scene, settings);
    auto const& g = loaded.scene.gravity;
    auto config = dem::read_config(loaded.configs.at(0), loaded.scene.dimension, {g[0], g[1], g[2]});
    config.loads = false;
    return config;
}

//! Slope of log y over log x by least squares, of the points with x between two values.
inline double exponent(std::map<double, double> const& points, double from, double to)
{
    double n = 0, x = 0, y = 0, xx = 0, xy = 0;
    for (auto const& [a, run_out] : points) {
        if (a < from || a > to) continue;
        double const u = std::log(a), v = std::log(run_out);
        n += 1;
        x += u;
        y += v;
        xx += u * u;
        xy += u * v;
    }
    return (n * xy - x * y) / (n * xx - x * x);
}

}  // namespace verification
