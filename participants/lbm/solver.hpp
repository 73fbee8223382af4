#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "coupler/base/state.hpp"
#include "participants/frame/rotating_frame.hpp"
#include "participants/lbm/config.hpp"
#include "participants/lbm/coverage.hpp"
#include "participants/lbm/domain.hpp"
#include "participants/lbm/fields.hpp"
#include "participants/lbm/halo.hpp"
#include "participants/lbm/kernels.hpp"
#include "participants/lbm/links.hpp"
#include "participants/lbm/phase.hpp"
#include "participants/lbm/populations.hpp"
#include "participants/lbm/relaxation.hpp"
#include "participants/lbm/rim_loads.hpp"
#include "participants/lbm/solids.hpp"
#include "participants/lbm/still_rows.hpp"
#include "participants/lbm/walls.hpp"

namespace lbm {

//! The discs or spheres of one step, SI. Their number may change from step to step.
struct BodiesView
{
    std::span<double const> position;          //!< [m], shape [body][D]
    std::span<double const> velocity;          //!< [m/s], shape [body][D]
    std::span<double const> angular_velocity;  //!< [1/s], shape [body], in space [body][3]
    std::span<double const> radius;            //!< R [m], the grain's own; the fluid sees hydrodynamic_radius * R
    std::span<std::uint64_t const> id = {};    //!< names that last; empty: the index is the name
};

//! What the fluid did to the bodies, SI, in their order; discs: per metre of depth.
struct LoadsView
{
    std::span<double const> force;   //!< [N], shape [body][D]
    std::span<double const> torque;  //!< about the centre [N m], shape as angular_velocity
};

//! What a step tells of solids at rest. Left out it takes less time; the fluid goes on alike.
enum class SolidLoads
{
    found,
    left_out
};

//! State of the fluid at a point, for Solver::set_state().
template <int D>
struct PointState
{
    std::array<double, D> velocity{};                    //!< [m/s]
    double pressure = 0;                                 //!< p - p_0 [Pa]
    std::array<std::array<double, D>, D> gradient = {};  //!< [a][b]: d u_a/d x_b [1/s]: the stress to start with
};

//! How the work of the last step was shared out.
struct Share
{
    //! Run by the kernel that knows grains, of all cells of the lattice [-]; of a shared one this process's part of it.
    double covered_cells;
    double rebuilt_bodies;  //!< whose solid fractions were computed anew, of all bodies [-]
};

//! The configuration. Throws Error (exit 2) if find_issues() refuses it.
Config const& checked(Config const& config);
//! The extra cost of layers of the solver whose state was kept.
std::vector<double> extra_of(sluice::State const& kept);
//! Throws Error (exit 2) unless so many processes can share the lattice of such a run.
void require_shareable(Config const& config, int processes);

//! Fluid with moving bodies (equations, limits: README.md): D2Q9 with discs, D3Q19 with spheres. SI outside, lattice
//! units inside. Several processes may share one lattice: each makes the same calls with the same bodies in the same
//! order and learns the same loads.
template <int D>
class Solver
{
 public:
    //! Throws Error (exit 2) if find_issues() refuses the configuration, or `peers`, who share the lattice, cannot.
    //! `extra`: what each layer of the lattice costs beyond its cells, in cells (slab_cost.hpp), for how it is shared.
    explicit Solver(Config const& config, ranks::Peers* peers = nullptr, std::vector<double> extra = {})
        : Solver(config, patches_of<D>(checked(config)), {}, peers, std::move(extra))
    {}
    //! With solids at rest instead of those of the configuration. Without `boxes` those that hold fluid are stored.
    Solver(Config const& config, std::vector<Patch<D>> patches, std::vector<Box> boxes = {},
           ranks::Peers* peers = nullptr, std::vector<double> extra = {});

    double time_step() const noexcept { return config_.step; }                           //!< [s]
    double time() const noexcept { return static_cast<double>(steps_) * config_.step; }  //!< [s]
    std::int64_t steps() const noexcept { return steps_; }
    Config const& config() const noexcept { return config_; }

    void set_bodies(BodiesView const& bodies);  //!< where they are at the start of the next step
    //! Solids finer than a cell, for the next `steps` steps; the configuration has a `phase`.
    void set_phase(PhaseView const& points, std::int64_t steps) { phase_->place(points, steps); }
    std::span<double const> phase_force() { return phase_->force(); }  //!< on each in these [N], mean; [point][D]
    void set_state(std::function<PointState<D>(std::array<double, D> const& at)> const& state);
    //! One time_step(). Throws Error (exit 6) if the run blew up.
    void step(SolidLoads on_solids = SolidLoads::found);
    LoadsView loads() const noexcept { return {force_, torque_}; }  //!< of the last step, relaxed if grains are light
    LoadsView exchange() const noexcept
    {
        return {exchange_, exchange_torque_};
    }  //!< the momentum the lattice lost, per step

    //! On solids at rest, of the last step that found them: with what they got in the step before, or as if that had
    //! been the same if it was left out.
    LoadsView solid_loads() const noexcept { return {solid_force_, solid_torque_}; }
    std::vector<double> solid_volumes() const;  //!< of their parts that are stored [cells]

    //! The first process gets all blocks, others their own.
    Fields fields(int coarsen = 1, FieldChoice const& choice = {});
    Energies energies();
    std::vector<Sample<D>> samples(std::span<std::array<double, D> const> places);  //!< places in the domain [m]
    double max_speed();                                                             //!< [m/s]
    //! Sum of rho dx^D over the cells that are stored, solids' fluid included (not that of interpolated bodies) [kg];
    //! in the plane per metre.
    double mass();
    std::array<double, D> momentum();  //!< of the same [N s]
    //! With interpolated surfaces: momentum that came into bodies in the last step with fluid that moves as they do
    //! [N s]; with exchange() it is what the fluid outside has lost.
    std::array<double, D> taken_along() const;
    Share share() const noexcept { return share_; }
    Layout const& layout() const noexcept { return domain_.whole(); }
    std::size_t bytes() const noexcept
    {
        return populations_.bytes() + coverage_.bytes() + still_.bytes() + (links_ ? links_->bytes() : 0);
    }  //!< of all that is large, in this process

    //! Puts in all that a run needs to go on: `steps`; `solids/exchange` [N, N m], with solids at rest, if found; of
    //! the bodies `bodies/id`, `bodies/place` (Body, lattice units), `bodies/displaced`; of the bodies of the last step
    //! `last/id`, `last/velocity` [m/s, 1/s], `last/exchange` [N, N m], with light grains `last/load`; `populations/0`
    //! and so on, shape [z][y][x], as doubles or, in single precision, floats as bytes: of a shared lattice those of
    //! this process, and `layers/extra`, the cost by which it is shared, if there is any.
    void keep(sluice::State& kept);
    //! Of a solver with the same configuration and extra cost. Throws Error (exit 7) for a state of another lattice.
    void restore(sluice::State const& kept);

 private:
    //! Velocity and angular velocity, or force and torque, of one body.
    static constexpr std::size_t freedoms = D + spins<D>;
    using Motion = std::array<double, freedoms>;

    void find_field();
    Relaxation of_row(std::ptrdiff_t r) const;
    std::array<double, D> acceleration_at(std::array<double, D> const& place, double const* velocity) const;
    void enter_rows(std::ptrdiff_t begin, std::ptrdiff_t end);
    void collide_rows();
    void note_held();
    Boundary::Held held_in(std::ptrdiff_t r, std::ptrdiff_t x, std::size_t axis) const;
    void collide_run(std::ptrdiff_t begin, std::ptrdiff_t end);
    //! How a row collides: with others in line without solids, or where solids rest; or on its own.
    enum class Way
    {
        plain,
        in_block,
        alone
    };
    Way way_of(std::ptrdiff_t r) const;
    bool has_still_solids(std::ptrdiff_t r) const;
    std::ptrdiff_t rows_in_line(std::ptrdiff_t r, std::ptrdiff_t end) const;
    template <class Collide>
    void collide_in_line(std::ptrdiff_t begin, std::ptrdiff_t end, Collide&& collide);
    void collide_solid_rows(std::ptrdiff_t begin, std::ptrdiff_t end);
    template <class Stored>
    void collide_covered_row(std::ptrdiff_t r, AnySlots<D> const& slots, std::span<std::uint32_t const> strips);
    bool all_rest(std::span<std::uint32_t const> strips) const;
    //! Whether a strip's solid moves and pushes cells by direct forcing.
    bool is_forced(Strip<D> const& strip) const
    {
        return config_.surface == Surface::forced && strip.body < static_cast<std::ptrdiff_t>(covering().size());
    }
    template <class Stored>
    void gather_still_row(std::ptrdiff_t r);
    template <class Stored>
    StillRows::Known<Stored> know_still_row(std::ptrdiff_t r);
    template <class Stored>
    void list_still_rows();
    template <class Stored>
    void prefetch_next(std::ptrdiff_t r) const;
    template <class Stored>
    void find_still_loads(std::ptrdiff_t r, SolidRow<Stored> const& solid);
    template <class Stored>
    void collide_still_row(std::ptrdiff_t r, AnySlots<D> const& slots);
    template <class Stored>
    void collide_still_block(std::ptrdiff_t r, std::ptrdiff_t count, OnTheWay& ends);
    std::size_t patches_with_loads() const noexcept { return finds_solid_loads_ ? coverage_.patches().size() : 0; }
    bool sum_loads();
    void add_parts(std::size_t index, std::vector<SumPart<freedoms>>& parts) const;
    std::vector<Motion> exchanged();
    void find_solid_loads(std::span<Motion const> strips, std::span<Motion const> rims);
    void find_loads();
    Motion relax(std::size_t body, Motion const& told);
    void check_bodies(BodiesView const& bodies) const;
    std::span<Body<D> const> covering() const  //!< bodies that cover cells in part
    {
        return links_ ? std::span<Body<D> const>() : std::span<Body<D> const>(bodies_);
    }
    double fluid_too_many(std::size_t body) const;
    std::array<double, spins<D>> torque_of_field(std::array<double, D> moment, std::array<double, D> const& a) const;
    void resize_loads(std::size_t bodies);
    void complete();
    void prepare_to_read();
    std::array<double, D> place_of(std::array<double, D> at) const;
    std::array<double, D> centre_of(std::ptrdiff_t x, std::ptrdiff_t r) const;
    std::array<double, 3> force_on(Relaxation const& row, std::ptrdiff_t x, double rho,
                                   std::array<double, D> const& velocity) const;
    void read_moments(std::ptrdiff_t r, RowState<D>& row) const;
    void leave_out_bodies(std::ptrdiff_t r, RowState<D>& row) const;
    void read_row(std::ptrdiff_t r, RowState<D>& row) const;
    template <std::size_t K, class Of>
    std::array<double, K> sum_over_rows(Of&& of_row) const;
    void watch();
    void report_blow_up();

    //! The fluid that a body displaces.
    struct Displaced
    {
        double mass;      //!< [kg]
        double gyration;  //!< squared radius of gyration [m2]
        Motion motion;    //!< of the body [m/s, 1/s]
    };
    //! What a step leaves to the next one about a body.
    struct Past
    {
        Motion motion, exchange;
        Motion load{};  //!< that it was told [N, N m]
    };

    Config config_;
    std::vector<double> extra_;  //!< cost of the layers of a shared lattice
    Relaxation relaxation_;
    std::array<double, 3> acceleration_{};  //!< uniform, of the coming step [m/s2]
    //! In a frame that turns, for the coming step: a = acceleration + field (x - point) - 2 w x u.
    struct Turning
    {
        frame::RotatingFrame<D> frame;
        frame::Matrix<D> field{};      //!< [1/s2]
        std::array<double, 3> rate{};  //!< w [rad/s]; 0 without Coriolis' part
    };
    std::optional<Turning> turning_;
    std::optional<Phase<D>> phase_;
    Domain<D> domain_;
    Layout const& layout_ = domain_.own();
    Walls walls_;
    Kernels<D> kernels_;
    Coverage<D> coverage_;
    RimLoads<D> rim_loads_;
    StillRows still_;
    std::optional<Links<D>> links_;  //!< bodies are surfaces, instead of covering cells
    sluice::Team team_;
    std::vector<std::ptrdiff_t> cuts_;  //!< rows between two of them are one thread's work
    Populations<D> populations_;
    std::optional<Halo<D>> halo_;  //!< of a shared lattice
    std::vector<Body<D>> bodies_;
    std::vector<Displaced> displaced_;
    std::vector<std::uint64_t> id_, last_id_;
    std::vector<Past> past_;          //!< of the bodies last_id_
    std::vector<Motion> strip_load_;  //!< force and torque [lattice units]
    std::vector<double> force_, torque_, exchange_, exchange_torque_;
    bool finds_solid_loads_ = true;       //!< in this step
    std::vector<Motion> solid_exchange_;  //!< of the last step with the patches [N, N m]; empty: left out
    std::vector<double> solid_force_, solid_torque_;
    std::vector<std::ptrdiff_t> covered_cells_;  //!< for each row
    Share share_{};
    std::int64_t steps_ = 0;
    bool complete_ = false;  //!< whether the populations from outside have been rewritten since the last step
};

}  // namespace lbm
