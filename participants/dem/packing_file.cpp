#include "participants/dem/packing_file.hpp"

#include <xxhash.h>

#include <cstdint>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <system_error>

#include "coupler/base/error.hpp"
#include "participants/dem/bytes.hpp"
#include "participants/dem/packing_start.hpp"

namespace dem {
namespace {

constexpr std::uint64_t magic = 0x3430504d45444c53;  // "SLDEMP04"; raise it when pour_packing changes

//! The numbers of a packing, free of padding.
template <int D>
struct Flat
{
    std::vector<double> numbers;     //!< per grain: centre, radius
    std::vector<std::uint32_t> who;  //!< per record: first, second
    std::vector<double> histories;   //!< per record: friction, rolling
    double kinetic_ratio = 0.0;
    static constexpr std::size_t per_grain = D + 1, per_history = D == 2 ? 2 : 6;
};

void visit(auto& archive, auto& flat)
{
    archive(flat.numbers);
    archive(flat.who);
    archive(flat.histories);
    archive(flat.kinetic_ratio);
}

template <class V>
void put(std::vector<double>& to, V v)
{
    each_number(v, [&](double number) { to.push_back(number); });
}
template <class V>
void take(double const*& from, V& v)
{
    each_number(v, [&](double& number) { number = *from++; });
}

template <int D>
Flat<D> flat(Packing<D> const& packing)
{
    Flat<D> flat;
    for (auto const& [centre, radius] : packing.place) put(flat.numbers, centre), put(flat.numbers, radius);
    for (auto const& r : packing.records) {
        flat.who.insert(flat.who.end(), {r.first, r.second});
        put(flat.histories, r.friction), put(flat.histories, r.rolling);
    }
    flat.kinetic_ratio = packing.kinetic_ratio;
    return flat;
}

template <int D>
std::optional<Packing<D>> packing_of(Flat<D> const& flat)
{
    std::size_t const grains = flat.numbers.size() / Flat<D>::per_grain, records = flat.who.size() / 2;
    if (flat.numbers.size() != grains * Flat<D>::per_grain || flat.who.size() != 2 * records ||
        flat.histories.size() != records * Flat<D>::per_history)
        return std::nullopt;
    Packing<D> packing;
    packing.place.resize(grains);
    packing.records.resize(records);
    packing.kinetic_ratio = flat.kinetic_ratio;
    double const* from = flat.numbers.data();
    for (auto& place : packing.place) take(from, place.centre), take(from, place.radius);
    from = flat.histories.data();
    for (std::size_t k = 0; k < records; ++k) {
        auto& r = packing.records[k];
        r.first = flat.who[2 * k];
        r.second = flat.who[2 * k + 1];
        take(from, r.friction), take(from, r.rolling);
    }
    return packing;
}

void add(ByteWriter& key, ContactConfig const& c)
{
    for (double const x :
         {c.normal_stiffness, c.youngs_modulus, c.poissons_ratio, c.damping_ratio, c.tangential_stiffness,
          c.tangential_damping, c.friction, c.rolling_friction, c.rolling_stiffness, c.rolling_damping})
        key(x);
    key(static_cast<std::uint8_t>(c.elasticity));
    key(static_cast<std::uint8_t>(c.rolling));
    key(static_cast<std::uint8_t>(c.may_pull));
}

//! What differs from a column poured with the usual sizes: names of packings that are kept stay theirs.
void add_preparation(ByteWriter& key, Config const& config)
{
    ColumnConfig const& c = *config.column;
    if (!config.sizes.is_uniform_number())
        key(config.sizes.numbers());
    else if (is_scattered(config))
        key(std::uint8_t{1});
    if (c.preparation == Preparation::poured && c.pouring_gravity == 0.0) return;
    key(static_cast<std::uint8_t>(c.preparation));
    key(c.packing_fraction);
    key(c.pouring_gravity);
}

}  // namespace

std::string packing_file_name(Config const& config)
{
    ByteWriter key;
    Vec3 const gravity = settling_gravity(config);
    for (double const x : {gravity.x, gravity.y, gravity.z, config.density, config.diameter_min, config.diameter_max})
        key(x);
    if (config.rotation && config.rotation->ramp == 0.0) {
        sluice::Rotation const& r = *config.rotation;
        for (auto const& vector : {r.point, r.direction})
            for (double const x : vector) key(x);
        key(r.rate);
        key(static_cast<std::uint8_t>(r.centrifugal + 2 * r.coriolis));
    }
    key(config.dimension);
    add(key, config.contact);
    if (config.column) {
        key(static_cast<std::uint8_t>(config.column->container));
        key(config.column->count);
        key(config.column->aspect_ratio);
        key(config.column->depth);
        key(config.column->seed);
        key(config.column->packing_friction);
        add_preparation(key, config);
    }
    for (WallConfig const& w : config.walls) {
        for (double const x : {w.point.x, w.point.y, w.point.z, w.normal.x, w.normal.y, w.normal.z, w.radius}) key(x);
        key(static_cast<std::uint8_t>(w.inside));
        if (w.mesh) key(w.mesh->hash);
        add(key, w.contact);
    }
    key(magic);
    char name[48];
    std::snprintf(name, sizeof name, "packing-%016llx.bin",
                  static_cast<unsigned long long>(XXH3_64bits(key.bytes.data(), key.bytes.size())));
    return name;
}

template <int D>
void write_packing(Packing<D> const& packing, std::filesystem::path const& file)
{
    ByteWriter writer;
    writer(magic);
    auto const content = flat(packing);
    visit(writer, content);
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

template <int D>
std::optional<Packing<D>> load_packing(std::filesystem::path const& file, std::string& damage)
{
    std::ifstream in(file, std::ios::binary);
    if (!in) return std::nullopt;
    std::vector<char> const text((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    auto const bytes = std::as_bytes(std::span(text));
    std::uint64_t seen = 0, stored = 0;
    Flat<D> flat;
    if (bytes.size() >= 2 * sizeof seen) {
        auto const content = bytes.first(bytes.size() - sizeof stored);
        ByteReader tail(bytes.last(sizeof stored));
        tail(stored);
        ByteReader reader(content);
        reader(seen);
        if (seen == magic && stored == XXH3_64bits(content.data(), content.size())) {
            visit(reader, flat);
            if (auto packing = packing_of(flat); packing && reader.at_end()) return packing;
        }
    }
    damage = "dem: " + file.string() + " is damaged and is made again.";
    return std::nullopt;
}

template void write_packing<2>(Packing<2> const&, std::filesystem::path const&);
template void write_packing<3>(Packing<3> const&, std::filesystem::path const&);
template std::optional<Packing<2>> load_packing<2>(std::filesystem::path const&, std::string&);
template std::optional<Packing<3>> load_packing<3>(std::filesystem::path const&, std::string&);

}  // namespace dem
