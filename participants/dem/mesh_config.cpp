#include <algorithm>
#include <cmath>
#include <string>

#include "coupler/base/checksum.hpp"
#include "coupler/base/error.hpp"
#include "coupler/base/format.hpp"
#include "coupler/scene/beside_scene.hpp"
#include "participants/dem/bytes.hpp"
#include "participants/dem/config_parts.hpp"
#include "participants/files/stl_file.hpp"

namespace dem {
namespace {

constexpr double farthest = 1e6;  //!< of a corner from the origin, along an axis [m]; as of a wall's point

void read_triangles(sluice::Reader r, MeshConfig& mesh)
{
    std::filesystem::path const file = r.text("file");
    double const scale = r.number_or("scale", 1.0, {.above = 0.0, .max = 1e6, .unit = "m"});
    r.finish();
    if (file.empty()) return;
    mesh.from = sluice::beside_scene(r, file).string();
    try {
        for (files::Triangle const& t : files::read_stl(mesh.from)) {
            auto& corners = mesh.corner.emplace_back();
            for (std::size_t k = 0; k < 3; ++k) corners[k] = {t[k][0], t[k][1], t[k][2]};
        }
    } catch (sluice::Error const& e) {
        r.refuse("file", std::string("cannot be used: ") + e.what());
        return;
    }
    double largest = 0.0;
    for (auto& corners : mesh.corner)
        for (Vec3& corner : corners) {
            corner = scale * corner;
            for (int k = 0; k < 3; ++k) largest = std::max(largest, std::abs(component(corner, k)));
        }
    if (largest <= farthest) return;
    r.problem("file", sluice::format("has a corner at %g m along an axis (must be within %g m). Try another scale.",
                                     largest, farthest));
}

void read_segments(sluice::Reader& wall, MeshConfig& mesh)
{
    sluice::Bounds const lengths{.min = -farthest, .max = farthest, .unit = "m"};
    for (sluice::Reader segment : wall.list("segments")) {
        auto const end = [&](char const* key) {
            auto const v = segment.numbers(key, 2, lengths);
            return Vec3{v.at(0), v.at(1), 0.0};
        };
        mesh.corner.push_back({end("from"), end("to"), Vec3{}});
        if (segment.has("to") && mesh.corner.back()[0] == mesh.corner.back()[1])
            segment.problem("to", "is where the segment begins (must be elsewhere).");
        segment.finish();
    }
    if (mesh.corner.empty())
        wall.problem("segments", "has no entry (needed: at least one, {from: [x, y], to: [x, y]}).");
}

}  // namespace

std::shared_ptr<MeshConfig const> read_mesh(sluice::Reader& wall, int dimension)
{
    MeshConfig mesh;
    if (auto file = wall.child_if("mesh")) {
        read_triangles(*file, mesh);
        if (dimension == 2) wall.problem("mesh", "is a surface in space (in the plane give segments).");
    }
    if (wall.has("segments")) {
        read_segments(wall, mesh);
        if (dimension == 3) wall.problem("segments", "are walls of the plane (in space give mesh).");
    }
    if (mesh.corner.empty()) return nullptr;
    ByteWriter all;
    all(mesh.corner);
    mesh.hash = sluice::checksum_of(all.bytes);
    return std::make_shared<MeshConfig const>(std::move(mesh));
}

}  // namespace dem
