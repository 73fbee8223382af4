// Solver: what the fluid does to bodies and to solids at rest.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <unordered_map>

#include "participants/lbm/solver.hpp"

namespace lbm {
namespace {

//! By the mass of the fluid displaced: what a body's velocity must stir in a step so that the fluid's answer of the
//! step before does not overshoot. A surface that starts suddenly feels rho c_s of sound and rho sqrt(nu/(pi t)) of
//! shear for each area, that is some (c_s + 4.5 sqrt(nu/pi))/a of its displaced mass in the first step; the factors
//! from free discs and spheres of 0.3 to 0.05 of the fluid's density, a = 3 to 6 cells, tau 0.53 to 2 (README, Light
//! grains).
double virtual_mass(double radius, double viscosity)
{
    return (0.9 / std::numbers::sqrt3 + 3.4 * std::sqrt(viscosity / std::numbers::pi)) / radius;
}

}  // namespace

//! Of a body that covers cells, or after these a patch.
template <int D>
void Solver<D>::add_parts(std::size_t index, std::vector<SumPart<freedoms>>& parts) const
{
    std::size_t const bodies = covering().size();
    auto const [begin, end] = coverage_.of_body(index);
    double const centre =
        index < bodies ? bodies_[index].centre[D - 1] : coverage_.patches()[index - bodies].centre[D - 1];
    std::size_t const first = parts.size();
    bool const whole = coverage_.has_all_of(index);
    for (std::size_t k = begin; k < end; ++k) {
        auto const layer = static_cast<std::int64_t>(std::floor(coverage_.strips()[k].arm[D - 1] + centre));
        if (parts.size() == first || parts.back().layer != layer) {
            if (whole) join(parts, first);
            parts.push_back({index, layer, {}});
        }
        for (std::size_t f = 0; f < freedoms; ++f) parts.back().sum[f] += strip_load_[k][f];
    }
    if (whole) join(parts, first);
}

//! Momentum and angular momentum of the step [lattice units]: by bodies, by patches, and by patches through cells that
//! are not stored. Added up in one order, whatever the number of threads and processes.
template <int D>
std::vector<typename Solver<D>::Motion> Solver<D>::exchanged()
{
    std::size_t const patches = patches_with_loads(), solids = covering().size() + patches;
    std::vector<Motion> sums;
    if (links_) sums = links_->impulses();
    if (solids == 0) return sums;
    constexpr std::size_t chunk = 64;
    std::vector<std::vector<SumPart<freedoms>>> of_chunk(solids / chunk + 1);
    team_.share(static_cast<std::ptrdiff_t>(solids), chunk, [&](std::ptrdiff_t begin, std::ptrdiff_t end) {
        auto const first = static_cast<std::size_t>(begin), last = static_cast<std::size_t>(end);
        for (std::size_t i = first; i < last; ++i) add_parts(i, of_chunk[first / chunk]);
    });
    std::vector<SumPart<freedoms>> parts;
    for (auto const& some : of_chunk) parts.insert(parts.end(), some.begin(), some.end());
    if (finds_solid_loads_) rim_loads_.add_parts(populations_, solids, parts);
    auto const of_covering = domain_.totals(parts, solids + patches);
    sums.insert(sums.end(), of_covering.begin(), of_covering.end());
    return sums;
}

//! Returns whether all loads are finite.
template <int D>
bool Solver<D>::sum_loads()
{
    std::size_t const n = bodies_.size(), patches = patches_with_loads();
    double const force_unit = config_.units().force_unit(), torque_unit = config_.units().torque_unit();
    std::vector<Motion> const sums = exchanged();
    bool finite = true;
    for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t f = 0; f < D; ++f) exchange_[D * i + f] = sums[i][f] * force_unit;
        for (std::size_t f = 0; f < spins<D>; ++f) exchange_torque_[spins<D> * i + f] = sums[i][D + f] * torque_unit;
        finite = finite && std::isfinite(std::accumulate(sums[i].begin(), sums[i].end(), 0.0));
    }
    find_loads();
    if (patches == 0)
        solid_exchange_.clear();
    else
        find_solid_loads(std::span(sums).subspan(n, patches), std::span(sums).subspan(n + patches));
    std::ptrdiff_t covered = std::accumulate(covered_cells_.begin(), covered_cells_.end(), std::ptrdiff_t{0});
    if (links_) covered += static_cast<std::ptrdiff_t>(links_->cells_here());
    share_.covered_cells = static_cast<double>(covered) / static_cast<double>(domain_.whole().stored());
    return finite;
}

//! From the momentum exchanged to the load on a body:
//!     load = (exchange of this step + exchange of the last)/2 + m_f (dU/dt - a)
//! The mean takes out the swing of period 2 that the populations thrown back inside a body make; half of the last
//! exchange is always under way. m_f = rho_0 V is fluid that the lattice keeps inside a body and that does not
//! exist: it is carried along and feels the body force. m_f a makes the buoyancy -rho_0 V a, exactly. dU is the change
//! of the body's velocity since the last step; a new body has no past.
template <int D>
void Solver<D>::find_loads()
{
    std::size_t const n = id_.size();
    std::unordered_map<std::uint64_t, std::size_t> where;
    bool const same = id_ == last_id_;
    for (std::size_t i = 0; !same && i < last_id_.size(); ++i) where.emplace(last_id_[i], i);
    std::vector<Past> now(n);
    double const rate = 1 / config_.step;
    for (std::size_t i = 0; i < n; ++i) {
        Displaced const& d = displaced_[i];
        double const inside = links_ ? 0.0 : d.mass;  // is carried along
        now[i].motion = d.motion;
        std::copy_n(exchange_.data() + D * i, D, now[i].exchange.begin());
        std::copy_n(exchange_torque_.data() + spins<D> * i, spins<D>, now[i].exchange.begin() + D);
        if (links_) {
            auto const& pressed = links_->pressed()[i];
            for (std::size_t k = 0; k < freedoms; ++k)
                now[i].exchange[k] +=
                    pressed[k] * (k < D ? config_.units().force_unit() : config_.units().torque_unit());
        }
        auto const found = same ? where.end() : where.find(id_[i]);
        Past const past = same ? past_[i] : found != where.end() ? past_[found->second] : Past{d.motion, {}};
        auto const load = [&](std::size_t k, double inertia) {
            return 0.5 * (now[i].exchange[k] + past.exchange[k]) + inertia * rate * (d.motion[k] - past.motion[k]);
        };
        std::array<double, D> between;  // while it changed by dU: what a frame that turns does then cancels
        for (std::size_t k = 0; k < D; ++k) between[k] = 0.5 * (d.motion[k] + past.motion[k]);
        auto const a = acceleration_at(place_of(bodies_[i].centre), between.data());
        for (std::size_t k = 0; k < D; ++k) force_[D * i + k] = load(k, inside) - fluid_too_many(i) * a[k];
        // what fluid at rest does to cells that are no fluid is not the body's
        auto const turned = links_ ? torque_of_field(links_->moment_in(i), a) : std::array<double, spins<D>>{};
        for (std::size_t k = 0; k < spins<D>; ++k)
            torque_[spins<D> * i + k] = load(D + k, inside * d.gyration) + turned[k];
        if (config_.lightest_grain > 0) now[i].load = relax(i, past.load);
    }
    past_ = std::move(now);
    if (!same) last_id_ = id_;
}

//! By a virtual mass C_v: (m + C_v) a' = load + C_v a + what else acts, a the acceleration in the last step, in which m
//! a less the load told was what else acted. If that goes on, whoever moves the body by m alone gets a' if told
//!     share load + (1 - share) (load told last),   share = m/(m + C_v)
//! No impulse is lost: (1/share - 1) steps of the load told are under way. Returns that.
template <int D>
typename Solver<D>::Motion Solver<D>::relax(std::size_t body, Motion const& told)
{
    double const viscosity = (relaxation_.tau - 0.5) / 3,
                 displaced = config_.density * std::pow(config_.hydrodynamic_radius, D),  // by the grain's volume
        share = config_.lightest_grain /
                (config_.lightest_grain + virtual_mass(bodies_[body].radius, viscosity) * displaced);
    Motion load;
    auto const relaxed = [&](double& now, std::size_t k) { now = load[k] = share * now + (1 - share) * told[k]; };
    for (std::size_t k = 0; k < D; ++k) relaxed(force_[D * body + k], k);
    for (std::size_t k = 0; k < spins<D>; ++k) relaxed(torque_[spins<D> * body + k], D + k);
    return load;
}

//! Mass of fluid in a body's place that the body force acts on or, where its cells are no fluid, that these displace
//! less than the body does [kg].
template <int D>
double Solver<D>::fluid_too_many(std::size_t body) const
{
    double const cells = links_ ? links_->cells_in(body) : 0.0;
    return displaced_[body].mass - cells * config_.units().mass_unit();
}

//! Torque [N m] of an acceleration on fluid, about where its first moment of volume [cells^2] is taken.
template <int D>
std::array<double, spins<D>> Solver<D>::torque_of_field(std::array<double, D> moment,
                                                        std::array<double, D> const& a) const
{
    for (double& component : moment) component *= config_.units().mass_unit() * config_.cell;
    return moment_of<D>(moment, a);
}

template <int D>
std::array<double, D> Solver<D>::taken_along() const
{
    if (!links_) return {};
    auto momentum = links_->taken_along();
    for (double& component : momentum) component *= config_.units().momentum_unit();
    return momentum;
}

//! The same for solids at rest, from what each got through cells that it covers and through those not stored.
template <int D>
void Solver<D>::find_solid_loads(std::span<Motion const> strips, std::span<Motion const> rims)
{
    double const force_unit = config_.units().force_unit(), torque_unit = config_.units().torque_unit();
    bool const last_is_known = !solid_exchange_.empty();
    solid_exchange_.resize(rims.size());
    for (std::size_t i = 0; i < rims.size(); ++i) {
        Motion now = strips[i];
        for (std::size_t k = 0; k < freedoms; ++k) now[k] += rims[i][k];
        for (std::size_t k = 0; k < freedoms; ++k) now[k] *= k < D ? force_unit : torque_unit;
        Motion const& last = last_is_known ? solid_exchange_[i] : now;
        auto const& patch = coverage_.patches()[i];
        double const mass_unit = config_.units().mass_unit();
        constexpr std::array<double, D> rest{};
        auto middle = patch.centre;  // of what is stored: the field is linear
        for (std::size_t k = 0; k < D; ++k) middle[k] += patch.first_moment[k] / std::max(patch.volume, 1e-300);
        auto const a = acceleration_at(place_of(middle), rest.data());
        for (std::size_t k = 0; k < D; ++k)
            solid_force_[D * i + k] = 0.5 * (now[k] + last[k]) - mass_unit * patch.volume * a[k];
        auto const of_field = torque_of_field(patch.first_moment, a);
        for (std::size_t k = 0; k < spins<D>; ++k)
            solid_torque_[spins<D> * i + k] = 0.5 * (now[D + k] + last[D + k]) - of_field[k];
        solid_exchange_[i] = now;
    }
}

template <int D>
std::vector<double> Solver<D>::solid_volumes() const
{
    std::vector<double> volumes;
    for (auto const& patch : coverage_.patches()) volumes.push_back(patch.volume);
    return volumes;
}

#define LBM_LOADS(D)                                               \
    template bool Solver<D>::sum_loads();                          \
    template std::array<double, D> Solver<D>::taken_along() const; \
    template std::vector<double> Solver<D>::solid_volumes() const;
LBM_LOADS(2)
LBM_LOADS(3)
#undef LBM_LOADS

}  // namespace lbm
