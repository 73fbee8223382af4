#include "participants/dem/steady_shear.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "participants/dem/measures.hpp"
#include "participants/dem/stress.hpp"

namespace dem {
namespace {

//! d sqrt(rho) of the grains: of a mean diameter.
template <int D>
double inertia_of(Grains<D> const& g)
{
    double mass = 0.0, volume = 0.0;
    for (std::size_t i = 0; i < g.size(); ++i) {
        mass += g.mass[i];
        volume += volume_of<D>(g.place[i].radius);
    }
    return mean_diameter(g) * std::sqrt(mass / volume);
}

}  // namespace

template <int D>
void SteadyShear::sample(Solver<D> const& solver)
{
    Shear const& shear = solver.setup().periodic.shear;
    strain_ = solver.state().cell.strain;
    if (strain_ < shear.steady_from) return;
    auto const a = averages(solver.setup(), solver.state());
    auto const across = static_cast<std::size_t>(shear.across);
    double const normal = a.stress(across, shear.across);
    if (!(normal > 0.0)) return;
    count_ += 1.0;
    angle_.add(friction_angle(a, shear.along, shear.across) * 180.0 / std::numbers::pi);
    ratio_.add(-a.stress(static_cast<std::size_t>(shear.along), shear.across) / normal);
    normal_.add(normal);
    fraction_.add(a.packing_fraction);
    inertial_.add(shear.rate * inertia_of(solver.grains()) / std::sqrt(normal));
}

std::vector<std::pair<std::string, double>> SteadyShear::facts() const
{
    std::vector<std::pair<std::string, double>> facts{{"shear strain", strain_}};
    if (count_ == 0.0) return facts;
    auto const add = [&](std::string const& name, Mean const& m, std::string const& unit) {
        double const mean = m.sum / count_;
        facts.emplace_back(name + unit, mean);
        facts.emplace_back(name + ", spread" + unit, std::sqrt(std::max(0.0, m.squares / count_ - mean * mean)));
    };
    add("friction angle", angle_, " [deg]");
    add("shear / normal stress", ratio_, "");
    add("normal stress", normal_, " [Pa]");
    add("packing fraction", fraction_, "");
    facts.emplace_back("inertial number", inertial_.sum / count_);
    return facts;
}

void SteadyShear::keep(sluice::State& state) const
{
    std::vector<double> numbers{count_, strain_};
    for (Mean const* mean : {&angle_, &ratio_, &normal_, &fraction_, &inertial_})
        numbers.insert(numbers.end(), {mean->sum, mean->squares});
    state.put("steady", std::span<double const>(numbers));
}

SteadyShear SteadyShear::kept(sluice::State const& state)
{
    auto const numbers = state.numbers("steady", 12);
    SteadyShear s;
    s.count_ = numbers[0];
    s.strain_ = numbers[1];
    std::size_t at = 2;
    for (Mean* mean : {&s.angle_, &s.ratio_, &s.normal_, &s.fraction_, &s.inertial_}) {
        *mean = {numbers[at], numbers[at + 1]};
        at += 2;
    }
    return s;
}

template void SteadyShear::sample<2>(Solver<2> const&);
template void SteadyShear::sample<3>(Solver<3> const&);

}  // namespace dem
