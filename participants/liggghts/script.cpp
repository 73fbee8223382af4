#include "participants/liggghts/script.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <numbers>
#include <sstream>

namespace liggghts {
namespace {

using dem::ContactConfig;
using dem::Vec3;

std::string digits(double number)
{
    char text[32];
    std::snprintf(text, sizeof text, "%.17g", number);
    return text;
}

std::string on_off(bool on)
{
    return on ? "on" : "off";
}

//! What LIGGGHTS calls the laws of this block, among others of grains.
std::string model_of(ContactConfig const& c, ContactConfig const& grains)
{
    std::string model = c.elasticity == dem::Elasticity::linear ? "model hooke/stiffness" : "model hertz";
    model += " tangential history";
    if (c.rolling == dem::Rolling::constant) model += " rolling_friction cdt";
    if (c.rolling == dem::Rolling::elastic_plastic)
        model += rolls_by_epsd3(c, grains) ? " rolling_friction epsd3" : " rolling_friction epsd2";
    return model;
}
std::string settings_of(ContactConfig const& c)
{
    bool const linear = c.elasticity == dem::Elasticity::linear;
    return std::string(linear ? "absolute_damping on " : "") + "tangential_damping " +
           on_off(linear || c.tangential_damping > 0.0) + " limitForce " + on_off(!c.may_pull);
}

//! The types of LIGGGHTS: the classes of the grains, then one for each wall.
struct Types
{
    dem::Config const& config;
    SizeClasses const& classes;

    std::size_t grains() const { return classes.classes.size(); }
    std::size_t count() const { return grains() + config.walls.size(); }
    bool is_wall(std::size_t type) const { return type >= grains(); }

    //! The laws of a pair of types; of two walls those of the grains, nobody asks.
    ContactConfig const& contact(std::size_t i, std::size_t j) const
    {
        std::size_t const most = std::max(i, j);
        return is_wall(most) && !is_wall(std::min(i, j)) ? config.walls[most - grains()].contact : config.contact;
    }
    //! Reduced mass [kg]: at a wall the grain's own.
    double mass(std::size_t i, std::size_t j) const
    {
        if (is_wall(i) && is_wall(j)) return 1.0;
        if (is_wall(i)) return classes.classes[j].mass;
        if (is_wall(j)) return classes.classes[i].mass;
        double const a = classes.classes[i].mass, b = classes.classes[j].mass;
        return a * b / (a + b);
    }
    //! R* sqrt(m* / I), I the inertia that epsd3 reckons its dashpot with, m R^2 (1 + 1/2 or 2/5) of each [-].
    double rolling_share(std::size_t i, std::size_t j) const
    {
        double const round = config.dimension == 2 ? 1.5 : 1.4;
        if (is_wall(i) || is_wall(j)) return 1.0 / std::sqrt(round);
        auto const &a = classes.classes[i], &b = classes.classes[j];
        double const ia = a.mass * a.radius * a.radius, ib = b.mass * b.radius * b.radius;
        double const effective = a.radius * b.radius / (a.radius + b.radius);
        return effective * std::sqrt(mass(i, j) / (round * ia * ib / (ia + ib)));
    }
};

using OfPair = std::function<double(std::size_t, std::size_t)>;

//! Material properties, as far as the laws ask for them.
class Properties
{
 public:
    Properties(std::ostream& out, std::size_t types) : out_(out), types_(types) {}

    void pairs(std::string const& name, OfPair const& of)
    {
        out_ << "fix p_" << name << " all property/global " << name << " peratomtypepair " << types_;
        for (std::size_t i = 0; i < types_; ++i)
            for (std::size_t j = 0; j < types_; ++j)  // to the last bit symmetric
                out_ << ' ' << digits(of(std::min(i, j), std::max(i, j)));
        out_ << '\n';
    }
    void types(std::string const& name, double value)
    {
        out_ << "fix p_" << name << " all property/global " << name << " peratomtype";
        for (std::size_t i = 0; i < types_; ++i) out_ << ' ' << digits(value);
        out_ << '\n';
    }
    void number(std::string const& name, double value)
    {
        out_ << "fix p_" << name << " all property/global " << name << " scalar " << digits(value) << '\n';
    }

 private:
    std::ostream& out_;
    std::size_t types_;
};

//! Restitution of a dashpot of this ratio that may pull: what LIGGGHTS takes its own ratio from.
double restitution_of(double damping_ratio)
{
    return std::exp(-std::numbers::pi * damping_ratio / std::sqrt(1.0 - damping_ratio * damping_ratio));
}

void write_laws(std::ostream& out, Types const& types)
{
    ContactConfig const& grains = types.config.contact;
    Properties p(out, types.count());
    if (grains.elasticity == dem::Elasticity::linear) {
        p.pairs("kn", [&](auto i, auto j) { return types.contact(i, j).normal_stiffness; });
        p.pairs("kt", [&](auto i, auto j) { return types.contact(i, j).tangential_stiffness; });
        p.pairs("gamman_abs", [&](auto i, auto j) {
            ContactConfig const& c = types.contact(i, j);
            return 2.0 * c.damping_ratio * std::sqrt(c.normal_stiffness * types.mass(i, j));
        });
        p.pairs("gammat_abs", [&](auto i, auto j) {
            ContactConfig const& c = types.contact(i, j);
            return 2.0 * c.tangential_damping * std::sqrt(c.tangential_stiffness * types.mass(i, j));
        });
    } else {
        out << "soft_particles yes\nhard_particles yes\n";
        p.types("youngsModulus", grains.youngs_modulus);
        p.types("poissonsRatio", grains.poissons_ratio);
        p.pairs("coefficientRestitution",
                [&](auto i, auto j) { return restitution_of(types.contact(i, j).damping_ratio); });
    }
    p.pairs("coefficientFriction", [&](auto i, auto j) { return types.contact(i, j).friction; });
    if (grains.rolling != dem::Rolling::none)
        p.pairs("coefficientRollingFriction", [&](auto i, auto j) { return types.contact(i, j).rolling_friction; });
    if (grains.rolling == dem::Rolling::elastic_plastic && rolls_by_epsd3(grains, grains)) {
        p.number("rollingStiffness", rolling_stiffness(grains));
        p.pairs("coefficientRollingViscousDamping",
                [&](auto i, auto j) { return types.contact(i, j).rolling_damping * types.rolling_share(i, j); });
    }
    out << "pair_style gran " << model_of(grains, grains) << ' ' << settings_of(grains) << "\npair_coeff * *\n";
}

//! The axis along which a vector lies: 0, 1, 2; -1: none.
int axis_of(Vec3 const& v)
{
    double const along[] = {std::abs(v.x), std::abs(v.y), std::abs(v.z)};
    for (int k = 0; k < 3; ++k)
        if (along[k] > 0.0 && along[(k + 1) % 3] == 0.0 && along[(k + 2) % 3] == 0.0) return k;
    return -1;
}

double component_of(Vec3 const& v, int axis)
{
    return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

std::string shape_of(dem::WallConfig const& wall, int dimension)
{
    constexpr char const* names = "xyz";
    bool const round = wall.radius > 0.0;
    int const axis = round && dimension == 2 ? 2 : axis_of(wall.normal);
    std::string shape(1, names[axis]);
    if (!round) return shape + "plane " + digits(component_of(wall.point, axis));
    return shape + "cylinder " + digits(wall.radius) + ' ' + digits(component_of(wall.point, (axis + 1) % 3)) + ' ' +
           digits(component_of(wall.point, (axis + 2) % 3));
}

void write_walls(std::ostream& out, Types const& types, double now)
{
    for (std::size_t w = 0; w < types.config.walls.size(); ++w) {
        auto const& wall = types.config.walls[w];
        if (!(wall.removed_at > now)) continue;
        out << "fix " << wall_name(w) << " all wall/gran " << model_of(wall.contact, types.config.contact)
            << " primitive type " << types.grains() + w + 1 << ' ' << shape_of(wall, types.config.dimension) << ' '
            << settings_of(wall.contact) << '\n';
    }
}

}  // namespace

std::string wall_name(std::size_t wall)
{
    return "wall_" + std::to_string(wall);
}

std::string script_of(dem::Config const& config, SizeClasses const& classes, std::string const& grains, double now)
{
    std::ostringstream out;
    Types const types{config, classes};
    out << "units si\ndimension " << config.dimension << "\nboundary m m " << (config.dimension == 2 ? 'p' : 'm')
        << "\natom_style granular\natom_modify map array sort 0 0\nnewton off\ncommunicate single vel yes\n"
        << grains
        << '\n'
        // contacts that have opened forget their springs only within this distance, by default never
        << "neighbor " << digits(dem::list_reach(dem::diameters(config).first))
        << " bin\nneigh_modify delay 0 every 1 check yes contact_distance_factor 1.05\n";
    write_laws(out, types);
    write_walls(out, types, now);
    double const weight = 1.0 - config.fluid_density / config.density, gravity = norm(config.gravity);
    if (gravity > 0.0)
        out << "fix gravity all gravity " << digits(weight * gravity) << " vector "
            << digits(config.gravity.x / gravity) << ' ' << digits(config.gravity.y / gravity) << ' '
            << digits(config.gravity.z / gravity) << '\n';
    out << "fix integration all nve/sphere\n";
    if (config.dimension == 2) out << "fix plane all enforce2d\n";
    out << "timestep " << digits(config.step) << '\n';
    return out.str();
}

template <int D>
std::string data_of(dem::Config const& config, dem::Grains<D> const& grains, SizeClasses const& classes)
{
    std::ostringstream out;
    double const largest = dem::diameters(config).second;
    Vec3 low{1, 1, 1}, high{-1, -1, -1};
    for (std::size_t i = 0; i < grains.size(); ++i) {
        Vec3 const c = dem::in_space(grains.place[i].centre);
        low = i == 0 ? c : Vec3{std::min(low.x, c.x), std::min(low.y, c.y), std::min(low.z, c.z)};
        high = i == 0 ? c : Vec3{std::max(high.x, c.x), std::max(high.y, c.y), std::max(high.z, c.z)};
    }
    out << "grains of a scene\n\n"
        << grains.size() << " atoms\n"
        << classes.classes.size() + config.walls.size() << " atom types\n\n";
    for (int k = 0; k < 3; ++k)
        out << digits(component_of(low, k) - largest) << ' ' << digits(component_of(high, k) + largest) << ' '
            << "xyz"[k] << "lo "
            << "xyz"[k] << "hi\n";
    out << "\nAtoms\n\n";
    for (std::size_t i = 0; i < grains.size(); ++i) {
        auto const& [centre, radius] = grains.place[i];
        Vec3 const c = dem::in_space(centre);
        out << i + 1 << ' ' << classes.of[i] + 1 << ' ' << digits(2.0 * radius) << ' '
            << digits(grains.mass[i] / dem::volume_of<D>(radius)) << ' ' << digits(c.x) << ' ' << digits(c.y) << ' '
            << digits(c.z) << '\n';
    }
    out << "\nVelocities\n\n";
    for (std::size_t i = 0; i < grains.size(); ++i) {
        Vec3 const v = dem::in_space(grains.motion[i].velocity);
        Vec3 w{};
        if constexpr (D == 2)
            w.z = grains.motion[i].spin;
        else
            w = grains.motion[i].spin;
        out << i + 1;
        for (double const number : {v.x, v.y, v.z, w.x, w.y, w.z}) out << ' ' << digits(number);
        out << '\n';
    }
    return out.str();
}

template std::string data_of<2>(dem::Config const&, dem::Grains<2> const&, SizeClasses const&);
template std::string data_of<3>(dem::Config const&, dem::Grains<3> const&, SizeClasses const&);

}  // namespace liggghts
