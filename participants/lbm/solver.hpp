#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "coupler/base/state.hpp"
#include "participants/lbm/config.hpp"
#include "participants/lbm/coverage.hpp"
#include "participants/lbm/fields.hpp"
#include "participants/lbm/populations.hpp"
#include "participants/lbm/relaxation.hpp"
#include "participants/lbm/walls.hpp"

namespace lbm {

struct SolidRow;

//! The discs of one step, SI. Their number may change from step to step.
struct DiscsView
{
    std::span<double const> position;          //!< [m], shape [disc][2]
    std::span<double const> velocity;          //!< [m/s], shape [disc][2]
    std::span<double const> angular_velocity;  //!< [1/s], shape [disc]
    std::span<double const> radius;            //!< R [m], the grain's own; the fluid sees hydrodynamic_radius * R
    std::span<std::uint64_t const> id = {};    //!< names that last; empty: the index is the name
};

//! What the fluid did to the discs, SI, in the order of the discs.
struct LoadsView
{
    std::span<double const> force;   //!< [N/m], shape [disc][2]
    std::span<double const> torque;  //!< about the centre [N m/m], shape [disc]
};

//! State of the fluid at a point, for Solver::set_state().
struct PointState
{
    double velocity[2] = {0, 0};        //!< [m/s]
    double pressure = 0;                //!< p - p_0 [Pa]
    double gradient[4] = {0, 0, 0, 0};  //!< du/dx, du/dy, dv/dx, dv/dy [1/s]: the stress to start with
};

//! How the work of the last step was shared out.
struct Share
{
    double covered_cells;  //!< run by the kernel that knows grains, of all cells [-]
    double rebuilt_discs;  //!< whose area fractions were computed anew, of all discs [-]
};

//! Fluid on a D2Q9 lattice with moving discs (equations, limits: README.md). SI outside, lattice units inside.
class Solver
{
 public:
    //! Throws Error (exit 2) if find_issues() refuses the configuration.
    explicit Solver(Config const& config);

    double time_step() const noexcept { return config_.step; }                           //!< [s]
    double time() const noexcept { return static_cast<double>(steps_) * config_.step; }  //!< [s]
    std::int64_t steps() const noexcept { return steps_; }
    Config const& config() const noexcept { return config_; }

    void set_discs(DiscsView const& discs);           //!< where they are at the start of the next step
    void set_obstacle(std::vector<double> fraction);  //!< solid at rest: area fraction of every cell, shape [y][x]
    void set_state(std::function<PointState(double x, double y)> const& at);
    void step();  //!< one time_step(); throws Error (exit 6) if the run blew up
    LoadsView loads() const noexcept { return {force_, torque_}; }  //!< of the last step
    LoadsView exchange() const noexcept
    {
        return {exchange_, exchange_torque_};
    }  //!< the momentum the lattice lost, per step

    Fields fields(int coarsen = 1);
    double max_speed();                //!< [m/s]
    double mass();                     //!< sum of rho dx^2, solids' fluid included [kg/m]
    std::array<double, 2> momentum();  //!< of the same [N s/m]
    Share share() const noexcept { return share_; }
    std::size_t bytes() const noexcept { return populations_.bytes(); }

    //! Puts in all that a run needs to go on: `steps`; of the discs `discs/id`, `discs/place` (Disc, lattice units),
    //! `discs/displaced`; of the discs of the last step `last/id`, `last/velocity` [m/s, 1/s], `last/exchange` [N/m, N
    //! m/m]; `populations/0` to `populations/8`, shape [y][x].
    void keep(sluice::State& kept);
    //! Of a solver with the same configuration. Throws Error (exit 7) for a state of another lattice.
    void restore(sluice::State const& kept);

 private:
    void collide_row(std::ptrdiff_t y);
    void collide_covered_row(std::ptrdiff_t y, std::span<std::uint32_t const> strips);
    void add_strip_forces(std::span<std::uint32_t const> strips, SolidRow const& solid);
    bool sum_loads();
    void find_loads();
    void check_discs(DiscsView const& discs) const;
    void resize_loads(std::size_t discs);
    void complete();
    void read_row(std::ptrdiff_t y, RowState& row) const;
    void watch();
    void report_blow_up();

    //! The fluid that a disc displaces.
    struct Displaced
    {
        double mass;                     //!< [kg/m]
        double gyration;                 //!< squared radius of gyration [m2]
        std::array<double, 3> velocity;  //!< the disc's velocity and angular velocity [m/s, 1/s]
    };
    //! What a step leaves to the next one about a disc: Displaced::velocity, exchanged force and torque [N/m, N m/m].
    struct Past
    {
        std::array<double, 3> velocity, exchange;
    };
    struct StripLoad
    {
        double force_x, force_y, torque;
    };
    using Kernel = void (*)(Slots const&, std::ptrdiff_t, std::ptrdiff_t, Relaxation const&, SolidRow const&);

    Config config_;
    Relaxation relaxation_;
    Walls walls_;
    Kernel fluid_ = nullptr, covered_ = nullptr;
    sluice::Team team_;
    Populations populations_;
    Coverage coverage_;
    std::vector<Disc> discs_;
    std::vector<Displaced> displaced_;
    std::vector<std::uint64_t> id_, last_id_;
    std::vector<Past> past_;  //!< of the discs last_id_
    std::vector<StripLoad> strip_load_;
    std::vector<double> force_, torque_, exchange_, exchange_torque_;
    std::vector<std::ptrdiff_t> covered_cells_;  //!< for each row
    Share share_{};
    std::int64_t steps_ = 0;
    bool complete_ = false;  //!< whether the populations from outside have been rewritten since the last step
};

}  // namespace lbm
