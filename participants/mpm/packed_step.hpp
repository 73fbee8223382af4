#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "participants/mpm/field.hpp"
#include "participants/mpm/grains.hpp"
#include "participants/mpm/grid.hpp"
#include "participants/mpm/packed_points.hpp"
#include "participants/mpm/packed_stencil.hpp"

namespace sluice {
class Team;
}

namespace mpm {

//! A step of the plane, four points at a time; the same equations as Solver's own (solver.hpp), to rounding. Points are
//! cut into chunks by their order; each adds up what it gives on a box of nodes of its own, and nodes add the boxes in
//! the order of the chunks: no bit depends on the number of threads.
class PackedStep
{
 public:
    //! What the points had and have [J/m], and what went wrong.
    struct Outcome
    {
        double kinetic_before = 0, kinetic_after = 0;
        double field = 0, stress = 0;  //!< work
        Booked booked;                 //!< all but numerical
        std::int64_t light_nodes = 0;
        std::size_t nodes = 0;
        double speed = 0;  //!< of the fastest wave over the fastest point [m/s]
        bool all_inside = true, all_upright = true;
    };

    static constexpr std::size_t chunk = 1024;  //!< points

    explicit PackedStep(int threads);
    PackedStep(PackedStep const& other);
    PackedStep& operator=(PackedStep const& other);
    PackedStep(PackedStep&&) noexcept;
    PackedStep& operator=(PackedStep&&) noexcept;
    ~PackedStep();

    //! Whether it knows all that a setup asks for.
    static bool serves(Setup<2> const& setup);

    void take(State<2> const& state) { points_.take(state); }
    void give(Setup<2> const& setup, State<2>& state) const { points_.give(state, setup.affine); }
    //! `loads`: force on each point, in the order of the state [N/m], or none. False: the points lie so far apart that
    //! boxes of nodes would be mostly empty; nothing was done.
    bool step(Setup<2> const& setup, double time, std::int64_t steps, double dt, std::span<Vec<2> const> loads,
              GrainContacts<2>& grains, Outcome& outcome);

 private:
    //! A chunk's points, its nodes, its share of the sums.
    struct Chunk
    {
        std::size_t begin = 0, end = 0;  //!< points, whole packs
        std::vector<double> numbers;
        Planes planes;
        Outcome outcome;
    };
    struct Gripped
    {
        std::size_t node;
        int axis;
        Grip grip;
    };

    template <class Each>
    void each_chunk(Each&& each);
    bool lay_out(Setup<2> const& setup);
    void sort(Setup<2> const& setup);
    void add_boxes(std::size_t from, std::size_t count, std::size_t to);
    void share_mean(std::size_t from, std::size_t volume, std::size_t value, std::size_t mean);
    void take_loads(Setup<2> const& setup, double half_width, std::span<Vec<2> const> loads);
    void book_loads(Setup<2> const& setup, double dt, Outcome& outcome);
    template <bool turning>
    void move_nodes(Setup<2> const& setup, Field<2> const& field, double dt, Outcome& outcome);
    void touch_grains(Setup<2> const& setup, double time, double dt, GrainContacts<2>& grains, Outcome& outcome);
    void hold_nodes(Setup<2> const& setup, double time, Outcome& outcome);
    void set_strain_velocities(Setup<2> const& setup, Outcome& outcome);
    template <bool affine, bool musl, bool shared>
    void run(Setup<2> const& setup, double time, double dt, std::span<Vec<2> const> loads, GrainContacts<2>& grains,
             Outcome& outcome);
    template <bool affine, bool shared, class Law>
    void deform(double dt, Law const& law);

    int threads_;
    std::unique_ptr<sluice::Team> team_;
    PackedPoints points_;
    std::vector<Chunk> chunks_;
    std::vector<double> numbers_;
    Planes nodes_;
    std::vector<Gripped> gripped_;
};

}  // namespace mpm
