#include "participants/dem/checkpoint.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <type_traits>

#include "coupler/base/error.hpp"
#include "participants/dem/neighbours.hpp"

namespace dem {
namespace {

//! Calls `each` for the numbers that a row consists of, without its padding.
template <int D, class Each>
void spread(Vec<D>& v, Each&& each)
{
    each_number(v, each);
}
template <int D, class Each>
void spread(Place<D>& place, Each&& each)
{
    each_number(place.centre, each);
    each(place.radius);
}
template <int D, class Each>
void spread(Motion<D>& motion, Each&& each)
{
    each_number(motion.velocity, each);
    each_number(motion.spin, each);
}
template <int D, class Each>
void spread(Load<D>& load, Each&& each)
{
    each_number(load.force, each);
    each_number(load.torque, each);
}
template <class Row>
concept Spreadable = std::is_class_v<Row> && requires(Row row)
{
    spread(row, [](auto&) {});
};

template <class Row>
std::size_t width()
{
    Row row{};
    std::size_t count = 0;
    spread(row, [&](auto&) { ++count; });
    return count;
}

//! The two ways of one walk over a state (visit): into named arrays, and out of them.
struct Putter
{
    sluice::State& kept;

    void operator()(std::string const& name, double number) { kept.put_number(name, number); }
    void operator()(std::string const& name, std::int64_t integer) { kept.put_integer(name, integer); }
    void operator()(std::string const& name, bool yes) { kept.put_integer(name, yes); }
    void operator()(std::string const& name, std::vector<double> const& values) { kept.put(name, std::span(values)); }
    //! An array that most scenes do not have.
    template <class Row>
    void if_any(std::string const& name, std::vector<Row> const& values)
    {
        if (!values.empty()) (*this)(name, values);
    }
    void operator()(std::string const& name, std::vector<std::int64_t> const& values)
    {
        kept.put(name, std::span(values));
    }
    void operator()(std::string const& name, std::vector<std::uint32_t> const& values)
    {
        std::vector<std::int64_t> const wide(values.begin(), values.end());
        kept.put(name, std::span(wide));
    }
    //! A vector of anything that can be spread, as rows of numbers.
    template <class Row>
    void operator()(std::string const& name, std::vector<Row> const& rows)
    {
        std::vector<double> numbers;
        numbers.reserve(rows.size() * width<Row>());
        for (Row row : rows) spread(row, [&](double number) { numbers.push_back(number); });
        kept.put(name, std::span<double const>(numbers));
    }
    template <class Row>
    requires(Spreadable<Row>) void operator()(std::string const& name, Row row)
    {
        (*this)(name, std::vector<Row>{row});
    }
};

struct Taker
{
    sluice::State const& kept;
    bool ok = true;  //!< false once an index was none

    void operator()(std::string const& name, double& number) { number = kept.number(name); }
    void operator()(std::string const& name, std::int64_t& integer) { integer = kept.integer(name); }
    void operator()(std::string const& name, bool& yes) { yes = kept.integer(name) != 0; }
    void operator()(std::string const& name, std::vector<double>& values)
    {
        auto const numbers = kept.numbers(name);
        values.assign(numbers.begin(), numbers.end());
    }
    void operator()(std::string const& name, std::vector<std::int64_t>& values)
    {
        auto const integers = kept.integers(name);
        values.assign(integers.begin(), integers.end());
    }
    void operator()(std::string const& name, std::vector<std::uint32_t>& values)
    {
        values.clear();
        for (std::int64_t const wide : kept.integers(name)) {
            ok = ok && wide >= 0 && wide <= std::numeric_limits<std::uint32_t>::max();
            values.push_back(static_cast<std::uint32_t>(wide));
        }
    }
    template <class Row>
    void if_any(std::string const& name, std::vector<Row>& values)
    {
        values.clear();
        if (kept.has(name)) (*this)(name, values);
    }
    template <class Row>
    void operator()(std::string const& name, std::vector<Row>& rows)
    {
        auto const numbers = kept.numbers(name);
        ok = ok && numbers.size() % width<Row>() == 0;
        rows.assign(numbers.size() / width<Row>(), {});
        auto next = numbers.begin();
        for (Row& row : rows)
            spread(row, [&](auto& number) { number = static_cast<std::decay_t<decltype(number)>>(*next++); });
    }
    template <class Row>
    requires(Spreadable<Row>) void operator()(std::string const& name, Row& row)
    {
        std::vector<Row> rows;
        (*this)(name, rows);
        ok = ok && rows.size() == 1;
        if (ok) row = rows[0];
    }
};

template <class Walk, class AnyGrains>
void visit_grains(Walk& walk, AnyGrains& g)
{
    walk("grains/place", g.place);
    walk("grains/motion", g.motion);
    walk("grains/half", g.half);
    walk("grains/mass", g.mass);
    walk("grains/inertia", g.inertia);
    walk("grains/contact", g.contact);
    walk("grains/external", g.external);
}

template <class Walk, class AnyHistory>
void visit_history(Walk& walk, std::string const& name, AnyHistory& h)
{
    walk(name + "friction", h.friction);
    walk(name + "rolling", h.rolling);
}

template <class Walk, class AnyState>
void visit(Walk& walk, AnyState& s)
{
    walk("time", s.time);
    walk("steps", s.steps);
    walk("grains/id", s.grains.id);
    visit_grains(walk, s.grains);
    walk("pairs/first", s.pairs.first);
    walk("pairs/other", s.pairs.other);
    walk("pairs/sqrt_mass", s.pairs.sqrt_mass);
    walk("pairs/image", s.pairs.image);
    visit_history(walk, "pairs/", s.pairs.history);
    for (std::size_t w = 0; w < s.walls.size(); ++w) {
        auto const name = "wall" + std::to_string(w) + "/";
        auto& wall = s.walls[w];
        walk(name + "active", wall.active);
        walk(name + "grain", wall.grain);
        walk.if_any(name + "facet", wall.facet);
        visit_history(walk, name, wall.history);
        walk(name + "shift", wall.shift);
        walk(name + "built_shift", wall.built_shift);
        walk(name + "velocity", wall.velocity);
        walk(name + "force", wall.force);
    }
    walk("built/centre", s.built);
    walk("built/count", s.rebuilds);
    walk("cell/extent", s.cell.extent);
    walk("cell/offset", s.cell.offset);
    walk("cell/slide", s.cell.slide);
    walk("cell/growth", s.cell.growth);
    walk("cell/strain", s.cell.strain);
    walk("cell/built_offset", s.cell.built_offset);
    walk("cell/built_height", s.cell.built_height);
    for (std::size_t k = 0; k < s.cell.pull.size(); ++k) walk("cell/pull_" + std::to_string(k), s.cell.pull[k]);
    walk.if_any("rest/asleep", s.rest.asleep);
    walk.if_any("rest/slow_since", s.rest.slow_since);
    walk.if_any("rest/load", s.rest.load);
    walk("booked/normal_dashpot", s.booked.normal_dashpot);
    walk("booked/tangential_dashpot", s.booked.tangential_dashpot);
    walk("booked/sliding", s.booked.sliding);
    walk("booked/rolling", s.booked.rolling);
    walk("booked/external_work", s.booked.external_work);
    walk("booked/wall_work", s.booked.wall_work);
    walk("booked/field_work", s.booked.field_work);
    walk("booked/removed_walls", s.booked.removed_walls);
    walk("booked/touch", s.booked.touch);
    walk("power/normal", s.power.normal);
    walk("power/tangential", s.power.tangential);
    walk("power/sliding", s.power.sliding);
    walk("power/rolling", s.power.rolling);
}

//! Looks at the sizes of a state's arrays of one entry a grain.
struct SizeCheck
{
    std::size_t size;
    bool ok = true;
    void operator()(char const*, auto const& values) { ok = ok && values.size() == size; }
};

//! Each entry of a mesh has a facet of it, and no other entry has one.
template <int D>
bool facets_fit(State<D> const& s, Setup<D> const& setup)
{
    for (std::size_t w = 0; w < s.walls.size(); ++w) {
        auto const* mesh = std::get_if<Mesh<D>>(&setup.walls[w].shape);
        std::size_t const facets = mesh ? mesh->facets->facets().size() : 0;
        std::vector<std::uint32_t> const& facet = s.walls[w].facet;
        if (facet.size() != (mesh ? s.walls[w].grain.size() : 0) ||
            !std::ranges::all_of(facet, [&](auto f) { return f < facets; }))
            return false;
    }
    return true;
}

//! Every index within bounds and every array as long as the kernels take it to be: they do not look.
template <int D>
bool is_consistent(State<D> const& s, std::size_t grains, Setup<D> const& setup)
{
    Features const& features = setup.features;
    SizeCheck each_grain{grains};
    visit_grains(each_grain, s.grains);
    auto const sized = [](auto const& array, std::size_t size) { return array.size() == size; };
    auto const contacts = [&](History<D> const& h, std::vector<std::uint32_t> const& partner) {
        std::size_t const n = partner.size();
        return sized(h.friction, features.friction ? n : 0) &&
               sized(h.rolling, features.rolling == Rolling::elastic_plastic ? n : 0) &&
               std::ranges::all_of(partner, [&](auto i) { return i < grains; });
    };
    Pairs<D> const& p = s.pairs;
    Rest<D> const& rest = s.rest;
    std::size_t const looked_at = rest.asleep.empty() ? 0 : grains;
    return each_grain.ok && sized(rest.asleep, looked_at) && sized(rest.slow_since, looked_at) &&
           sized(rest.load, looked_at) && sized(s.grains.id, grains) && sized(s.built, grains) &&
           sized(p.first, grains + 1) && p.first.front() == 0 && p.first.back() == p.other.size() &&
           std::ranges::is_sorted(p.first) && sized(p.sqrt_mass, p.other.size()) && contacts(p.history, p.other) &&
           sized(p.image, features.periodic ? p.other.size() : 0) &&
           std::ranges::all_of(p.image, [](auto image) { return image < image_count<D>; }) &&
           std::ranges::all_of(s.walls, [&](WallContacts<D> const& w) { return contacts(w.history, w.grain); }) &&
           facets_fit(s, setup);
}

//! Whether the cell has a length along its periodic axes.
template <int D>
bool has_room(Periodic<D> const& periodic, Cell<D> const& cell)
{
    bool yes = std::isfinite(cell.offset);
    for (int k = 0; k < D; ++k)
        yes = yes && (!periodic.axis[static_cast<std::size_t>(k)] ||
                      (std::isfinite(component(cell.extent, k)) && component(cell.extent, k) > 0.0));
    return yes;
}

}  // namespace

template <int D>
void keep(State<D> const& state, sluice::State& kept)
{
    Putter putter{kept};
    kept.put_integer("walls", static_cast<std::int64_t>(state.walls.size()));
    visit(putter, state);
}

template <int D>
State<D> kept_state(sluice::State const& kept, Setup<D> const& setup, std::size_t grains)
{
    State<D> state;
    state.walls.resize(setup.walls.size());
    Taker taker{kept};
    bool const walls = kept.integer("walls") == static_cast<std::int64_t>(setup.walls.size());
    if (walls) visit(taker, state);
    bool const fits = walls && taker.ok && has_room(setup.periodic, state.cell);
    sluice::require(fits && is_consistent(state, grains, setup), [&] {
        return sluice::Error("dem: the checkpoint is not a state of " + std::to_string(grains) + " grains and " +
                                 std::to_string(setup.walls.size()) +
                                 " walls (must come from the same scene). Resume from an older one.",
                             sluice::Exit::io);
    });
    derive_from_list(setup, state.pairs, grains);
    for (WallContacts<D>& wall : state.walls) wall.foot.resize(wall.facet.size());
    place_images(setup.periodic, state.cell);
    return state;
}

namespace {

//! Calls `visit(name, hash, file, what)` for what came from files.
template <class Visit>
void each_source(Config const& config, Visit&& visit)
{
    if (config.grains_hash != 0) visit("source/grains", config.grains_hash, config.grains_from, "grains");
    for (std::size_t w = 0; w < config.walls.size(); ++w)
        if (auto const& mesh = config.walls[w].mesh)
            visit("source/wall" + std::to_string(w), mesh->hash, mesh->from, "facets");
}

}  // namespace

void keep_source(Config const& config, sluice::State& kept)
{
    each_source(config, [&](std::string const& name, std::uint64_t hash, auto const&, auto const&) {
        kept.put_integer(name, std::bit_cast<std::int64_t>(hash));
    });
}

void require_source(Config const& config, sluice::State const& kept)
{
    each_source(config, [&](std::string const& name, std::uint64_t hash, std::string const& file, char const* what) {
        bool const same = kept.has(name) && std::bit_cast<std::uint64_t>(kept.integer(name)) == hash;
        sluice::require(same, [&] {
            return sluice::Error("dem: " + file + " holds other " + what +
                                     " than when the run began (must be the same). Put the file back, or start a new "
                                     "run.",
                                 sluice::Exit::io);
        });
    });
}

template void keep<2>(State<2> const&, sluice::State&);
template void keep<3>(State<3> const&, sluice::State&);
template State<2> kept_state<2>(sluice::State const&, Setup<2> const&, std::size_t);
template State<3> kept_state<3>(sluice::State const&, Setup<3> const&, std::size_t);

}  // namespace dem
