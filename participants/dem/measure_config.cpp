#include "participants/dem/measure_config.hpp"

#include <algorithm>
#include <numbers>

#include "participants/dem/config.hpp"

namespace dem {
namespace {

constexpr std::size_t standard_count = 5;  //!< the first names: what is measured unless a scene says otherwise
constexpr std::string_view standard = "standard";

void want_standard(MeasuresConfig& m)
{
    for (std::size_t k = 0; k < standard_count; ++k) m.of[k].wanted = true;
}

//! Options of one measure, if it has any besides its interval.
void read_options(sluice::Reader& r, Measure which, Config const& config, MeasuresConfig& m)
{
    m[which].wanted = true;
    m[which].interval = r.number_or("interval", m[which].interval, {.min = 0.0, .unit = "s"});
    switch (which) {
        case Measure::front:
            m.sectors.count = static_cast<std::size_t>(r.integer_or("sectors", 16, {.min = 1, .max = 3600}));
            m.sectors.percentile = r.number_or("percentile", 90.0, {.min = 0.0, .max = 100.0});
            if (r.has("over"))
                m.sectors.angle = std::numbers::pi * (r.choice("over", {"quarter", "circle"}) == 0 ? 0.5 : 2.0);
            break;
        case Measure::coordination:
            m.most_contacts = static_cast<std::size_t>(r.integer_or("most", 12, {.min = 1, .max = 100}));
            m.wall_contacts = r.flag_or("walls", true);
            break;
        case Measure::profile:
        case Measure::voronoi:
            m.slice = r.number_or("slice", m.slice, {.min = 0.0, .max = 1e6, .unit = "m"});
            if (config.dimension == 3 && r.has("along")) m.radial = r.choice("along", {"x", "radius"}) == 1;
            break;
        default:
            break;
    }
}

}  // namespace

bool MeasuresConfig::need_ledger(double series) const
{
    return std::ranges::any_of(std::array{Measure::energies, Measure::drift}, [&](Measure m) {
        Wanted const& asked = (*this)[m];
        return asked.wanted && (asked.interval > 0.0 || series > 0.0);
    });
}

MeasuresConfig read_measures(sluice::Reader& r, Config const& config)
{
    MeasuresConfig m;
    bool const round = config.column && config.column->container != Container::box;
    m.radial = round;
    if (round) m.sectors.angle = std::numbers::pi * (config.column->container == Container::quarter ? 0.5 : 2.0);
    m.stated = r.has("measures");
    if (!m.stated) {
        want_standard(m);
        return m;
    }
    if (r.is_list("measures")) {
        std::vector<std::string> names(measure_names.begin(), measure_names.end());
        names.emplace_back(standard);
        for (std::size_t const index : r.names_of("measures", "measure", names, 1))
            index < measure_names.size() ? void(m.of[index].wanted = true) : want_standard(m);
    } else {
        auto measures = r.child("measures");
        if (auto all = measures.child_if(standard)) {
            want_standard(m);
            all->finish();
        }
        for (std::size_t k = 0; k < measure_names.size(); ++k)
            if (auto options = measures.child_if(measure_names[k])) {
                read_options(*options, static_cast<Measure>(k), config, m);
                options->finish();
            }
        measures.finish();
    }
    bool const front = m[Measure::front].wanted;
    if (front && config.dimension == 2)
        r.problem("measures",
                  "has front, which looks at sectors about the vertical axis (needs dimension: 3). In the "
                  "plane run_out has the front.");
    else if (front && m.sectors.angle == 0.0)
        r.problem("measures",
                  "has front without saying what the sectors divide (the column is none of quarter, "
                  "cylinder). Add front: {over: quarter} or {over: circle}; run_out has the front along x.");
    return m;
}

}  // namespace dem
