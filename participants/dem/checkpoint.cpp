#include "participants/dem/checkpoint.hpp"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <span>
#include <string>

#include "coupler/base/error.hpp"

namespace dem {
namespace {

//! The two ways of one walk over a state (visit): into named arrays, and out of them.
struct Putter
{
    sluice::State& kept;

    void operator()(std::string const& name, double number) { kept.put_number(name, number); }
    void operator()(std::string const& name, std::int64_t integer) { kept.put_integer(name, integer); }
    void operator()(std::string const& name, bool yes) { kept.put_integer(name, yes); }
    void operator()(std::string const& name, std::vector<double> const& values) { kept.put(name, std::span(values)); }
    void operator()(std::string const& name, std::vector<std::uint32_t> const& values)
    {
        std::vector<std::int64_t> const wide(values.begin(), values.end());
        kept.put(name, std::span(wide));
    }
    void operator()(std::string const& name, std::vector<std::uint8_t> const& values)
    {
        kept.put(name, std::as_bytes(std::span(values)));
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
    void operator()(std::string const& name, std::vector<std::uint32_t>& values)
    {
        values.clear();
        for (std::int64_t const wide : kept.integers(name)) {
            ok = ok && wide >= 0 && wide <= std::numeric_limits<std::uint32_t>::max();
            values.push_back(static_cast<std::uint32_t>(wide));
        }
    }
    void operator()(std::string const& name, std::vector<std::uint8_t>& values)
    {
        values.clear();
        for (std::byte const byte : kept.bytes(name)) values.push_back(static_cast<std::uint8_t>(byte));
    }
};

template <class Walk, class AnyGrains>
void visit_grains(Walk& walk, AnyGrains& g)
{
    walk("grains/x", g.x);
    walk("grains/y", g.y);
    walk("grains/angle", g.angle);
    walk("grains/vx", g.vx);
    walk("grains/vy", g.vy);
    walk("grains/spin", g.spin);
    walk("grains/radius", g.radius);
    walk("grains/mass", g.mass);
    walk("grains/inertia", g.inertia);
    walk("grains/fx", g.fx);
    walk("grains/fy", g.fy);
    walk("grains/torque", g.torque);
    walk("grains/external_fx", g.external_fx);
    walk("grains/external_fy", g.external_fy);
    walk("grains/external_torque", g.external_torque);
    walk("grains/half_vx", g.half_vx);
    walk("grains/half_vy", g.half_vy);
    walk("grains/half_spin", g.half_spin);
}

template <class Walk, class AnyState>
void visit(Walk& walk, AnyState& s)
{
    walk("time", s.time);
    walk("steps", s.steps);
    visit_grains(walk, s.grains);
    walk("pairs/first", s.pairs.first);
    walk("pairs/other", s.pairs.other);
    walk("pairs/spring", s.pairs.spring);
    walk("pairs/sqrt_mass", s.pairs.sqrt_mass);
    walk("pairs/lossy_n", s.pairs.lossy_n);
    walk("pairs/lossy_t", s.pairs.lossy_t);
    walk("pairs/slides", s.pairs.slides);
    for (std::size_t w = 0; w < s.wall_contacts.size(); ++w) {
        auto const name = "wall" + std::to_string(w) + "/";
        auto& wall = s.wall_contacts[w];
        walk(name + "active", wall.active);
        walk(name + "grain", wall.grain);
        walk(name + "spring", wall.spring);
        walk(name + "lossy_n", wall.lossy_n);
        walk(name + "lossy_t", wall.lossy_t);
        walk(name + "slides", wall.slides);
    }
    walk("built/x", s.built_x);
    walk("built/y", s.built_y);
    walk("built/count", s.rebuilds);
    walk("booked/normal_dashpot", s.booked.normal_dashpot);
    walk("booked/tangential_dashpot", s.booked.tangential_dashpot);
    walk("booked/sliding", s.booked.sliding);
    walk("booked/external_work", s.booked.external_work);
    walk("booked/removed_walls", s.booked.removed_walls);
    walk("booked/touch", s.booked.touch);
    walk("power/normal", s.power.normal);
    walk("power/tangential", s.power.tangential);
    walk("power/sliding", s.power.sliding);
}

//! Looks at the sizes of a state's arrays of one number a grain.
struct SizeCheck
{
    std::size_t size;
    bool ok = true;
    void operator()(char const*, std::vector<double> const& values) { ok = ok && values.size() == size; }
};

//! Every index within bounds and every array as long as the kernels take it to be: they do not look.
bool is_consistent(State const& s, std::size_t grains, bool ledger)
{
    SizeCheck each_grain{grains};
    visit_grains(each_grain, s.grains);
    auto const sized = [](auto const& array, std::size_t size) { return array.size() == size; };
    auto const contacts = [&](auto const& list, std::vector<std::uint32_t> const& partner) {
        std::size_t const booked = ledger ? partner.size() : 0;
        return sized(list.spring, partner.size()) && sized(list.lossy_n, booked) && sized(list.lossy_t, booked) &&
               sized(list.slides, booked) && std::ranges::all_of(partner, [&](auto i) { return i < grains; });
    };
    Pairs const& p = s.pairs;
    return each_grain.ok && sized(s.built_x, grains) && sized(s.built_y, grains) && sized(p.first, grains + 1) &&
           p.first.front() == 0 && p.first.back() == p.other.size() && std::ranges::is_sorted(p.first) &&
           sized(p.sqrt_mass, p.other.size()) && contacts(p, p.other) &&
           std::ranges::all_of(s.wall_contacts, [&](WallContacts const& w) { return contacts(w, w.grain); });
}

}  // namespace

void keep(State const& state, sluice::State& kept)
{
    Putter putter{kept};
    kept.put_integer("walls", static_cast<std::int64_t>(state.wall_contacts.size()));
    visit(putter, state);
}

State kept_state(sluice::State const& kept, Setup const& setup, std::size_t grains)
{
    State state;
    state.wall_contacts.resize(setup.walls.size());
    Taker taker{kept};
    bool const walls = kept.integer("walls") == static_cast<std::int64_t>(setup.walls.size());
    if (walls) visit(taker, state);
    sluice::require(walls && taker.ok && is_consistent(state, grains, setup.features.ledger), [&] {
        return sluice::Error("dem: the checkpoint is not a state of " + std::to_string(grains) + " grains and " +
                                 std::to_string(setup.walls.size()) +
                                 " walls (must come from the same scene). Resume from an older one.",
                             sluice::Exit::io);
    });
    return state;
}

}  // namespace dem
