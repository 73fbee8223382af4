#pragma once

#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "participants/dem/solver.hpp"

//! A column of spheres between four sides on a floor, as our solver has it in LIGGGHTS' order, and as the real LIGGGHTS
//! 3.8 reads it: hooke/stiffness with absolute damping, tangential history, cdt rolling.
namespace liggghts {

inline constexpr double kn = 1e5, kt = 2e5 / 7.0, mu = 0.5, mu_r = 0.079;  // N/m, N/m, -, -
inline constexpr double gamma_n = 0.953, gamma_t = 0.477;                  // N s/m
inline constexpr double density = 2650.0, step = 5e-6, skin = 1e-3;        // kg/m3, s, m

inline dem::Setup<3> setup(double side)
{
    dem::Setup<3> s;
    s.gravity = {0.0, 0.0, -9.81};
    s.law.normal = {.stiffness = kn, .damping = gamma_n, .floor = -std::numeric_limits<double>::infinity()};
    s.law.tangential = {.stiffness = kt, .damping = gamma_t, .friction = mu};
    s.law.rolling = {.friction = mu_r};
    s.skin = skin;
    s.absolute_damping = true;
    s.loads = false;
    s.features = {.friction = true, .rolling = dem::Rolling::constant, .scheme = dem::Scheme::liggghts};
    auto const wall = [&](dem::Vec3 point, dem::Vec3 normal) {
        s.walls.push_back({.name = "w", .shape = dem::Plane<3>{point, normal}, .motion = {}, .law = s.law});
    };
    wall({}, {0, 0, 1});
    wall({}, {1, 0, 0});
    wall({}, {0, 1, 0});
    wall({side, 0, 0}, {-1, 0, 0});
    wall({0, side, 0}, {0, -1, 0});
    return s;
}

//! A data file; `atoms` heads the section of grains: "Atoms", for LAMMPS "Atoms # sphere". Ids count from 1.
inline void write_data(std::filesystem::path const& file, dem::Grains<3> const& g, double side, char const* atoms)
{
    std::ofstream out(file);
    out.precision(17);
    out << "column\n\n"
        << g.size() << " atoms\n1 atom types\n\n0 " << 4.0 * side << " xlo xhi\n0 " << side << " ylo yhi\n0 "
        << 3.0 * side << " zlo zhi\n\n"
        << atoms << "\n\n";
    for (std::size_t i = 0; i < g.size(); ++i) {
        auto const& [c, r] = g.place[i];
        out << i + 1 << " 1 " << 2.0 * r << ' ' << density << ' ' << c.x << ' ' << c.y << ' ' << c.z << '\n';
    }
    out << "\nVelocities\n\n";
    for (std::size_t i = 0; i < g.size(); ++i) {
        auto const& [v, w] = g.motion[i];
        out << i + 1 << ' ' << v.x << ' ' << v.y << ' ' << v.z << ' ' << w.x << ' ' << w.y << ' ' << w.z << '\n';
    }
}

//! Commands up to the first run, for the grains in `data` beside it. contact_distance_factor above 1: else LIGGGHTS
//! keeps the history of contacts that have opened.
inline std::string commands(std::string const& data, double side)
{
    std::ostringstream in;
    in.precision(17);
    std::string const model = "model hooke/stiffness tangential history rolling_friction cdt ";
    std::string const damped = "absolute_damping on tangential_damping on\n";
    in << "units si\natom_style granular\natom_modify map array\nboundary f f f\nnewton off\n"
          "communicate single vel yes\nread_data "
       << data << "\nneighbor " << skin
       << " bin\nneigh_modify delay 0 every 1 check yes contact_distance_factor 1.05\n";
    int n = 0;
    for (auto const& [name, value] : std::vector<std::pair<char const*, double>>{{"kn", kn},
                                                                                 {"kt", kt},
                                                                                 {"gamman_abs", gamma_n},
                                                                                 {"gammat_abs", gamma_t},
                                                                                 {"coefficientFriction", mu},
                                                                                 {"coefficientRollingFriction", mu_r}})
        in << "fix m" << n++ << " all property/global " << name << " peratomtypepair 1 " << value << '\n';
    in << "pair_style gran " << model << damped << "pair_coeff * *\nfix grav all gravity 9.81 vector 0.0 0.0 -1.0\n";
    for (auto const& [plane, at] : std::vector<std::pair<char const*, double>>{
             {"xplane", 0.0}, {"xplane", side}, {"yplane", 0.0}, {"yplane", side}, {"zplane", 0.0}})
        in << "fix w" << n++ << " all wall/gran " << model << "primitive type 1 " << plane << ' ' << at << ' '
           << damped;
    in << "fix integr all nve/sphere\ntimestep " << step << '\n';
    return in.str();
}

//! What a dump of `id` and `columns` more numbers a grain, sorted by id, ends with; empty if a grain is missing.
inline std::vector<std::vector<double>> last_of_dump(std::filesystem::path const& file, std::size_t grains,
                                                     std::size_t columns)
{
    std::ifstream in(file);
    std::vector<std::vector<double>> rows;
    for (std::string line; std::getline(in, line);) {
        if (line.rfind("ITEM: ATOMS", 0) != 0) continue;
        rows.assign(grains, std::vector<double>(columns));
        for (std::size_t i = 0; i < grains; ++i) {
            std::size_t id = 0;
            in >> id;
            for (double& number : rows[i]) in >> number;
            if (!in || id != i + 1) return {};
        }
    }
    return rows;
}

}  // namespace liggghts
