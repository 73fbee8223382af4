#include "participants/dem/packing_file.hpp"

#include <xxhash.h>

#include <cstdint>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <system_error>

#include "coupler/base/error.hpp"
#include "participants/dem/bytes.hpp"

namespace dem {
namespace {

constexpr std::uint64_t magic = 0x3130504d45444c53;  // "SLDEMP01"; raise it when pour_packing changes

void visit(auto& archive, auto& packing)
{
    archive(packing.x);
    archive(packing.y);
    archive(packing.radius);
    archive(packing.springs);
    archive(packing.kinetic_ratio);
}

bool is_consistent(Packing const& p)
{
    return p.x.size() == p.radius.size() && p.y.size() == p.radius.size();
}

}  // namespace

std::string packing_file_name(Config const& config)
{
    ByteWriter key;
    ContactConfig const& c = config.contact;
    for (double x : {config.gravity.x, config.gravity.y, config.density, config.diameter_min, config.diameter_max,
                     c.normal_stiffness, c.damping_ratio, c.tangential_stiffness, c.tangential_damping, c.friction})
        key(x);
    if (config.column) {
        key(config.column->count);
        key(config.column->aspect_ratio);
        key(config.column->seed);
        key(config.column->packing_friction);
    }
    for (WallConfig const& w : config.walls)
        for (double x : {w.point.x, w.point.y, w.normal.x, w.normal.y, w.friction}) key(x);
    key(magic);
    char name[48];
    std::snprintf(name, sizeof name, "packing-%016llx.bin",
                  static_cast<unsigned long long>(XXH3_64bits(key.bytes.data(), key.bytes.size())));
    return name;
}

void write_packing(Packing const& packing, std::filesystem::path const& file)
{
    ByteWriter writer;
    writer(magic);
    visit(writer, packing);
    writer(static_cast<std::uint64_t>(XXH3_64bits(writer.bytes.data(), writer.bytes.size())));
    std::filesystem::path aside = file;
    aside += ".part";
    std::error_code error;
    if (file.has_parent_path()) std::filesystem::create_directories(file.parent_path(), error);
    std::ofstream out(aside, std::ios::binary | std::ios::trunc);
    out.write(reinterpret_cast<char const*>(writer.bytes.data()), static_cast<std::streamsize>(writer.bytes.size()));
    out.close();
    if (out) std::filesystem::rename(aside, file, error);
    sluice::require(out && !error, [&] {
        return sluice::Error("dem: the packing " + file.string() + " cannot be written (" +
                                 (error ? error.message() : std::string("disk full or no permission")) + ").",
                             sluice::Exit::io);
    });
}

std::optional<Packing> load_packing(std::filesystem::path const& file, std::string& damage)
{
    std::ifstream in(file, std::ios::binary);
    if (!in) return std::nullopt;
    std::vector<char> const text((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    auto const bytes = std::as_bytes(std::span(text));
    std::uint64_t seen = 0, stored = 0;
    Packing packing;
    if (bytes.size() >= 2 * sizeof seen) {
        auto const content = bytes.first(bytes.size() - sizeof stored);
        ByteReader tail(bytes.last(sizeof stored));
        tail(stored);
        ByteReader reader(content);
        reader(seen);
        if (seen == magic && stored == XXH3_64bits(content.data(), content.size())) {
            visit(reader, packing);
            if (reader.at_end() && is_consistent(packing)) return packing;
        }
    }
    damage = "dem: " + file.string() + " is damaged and is made again.";
    return std::nullopt;
}

}  // namespace dem
