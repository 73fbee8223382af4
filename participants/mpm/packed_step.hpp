#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "participants/mpm/pace.hpp"
#include "participants/mpm/packed_nodes.hpp"

namespace sluice {
class Team;
}

namespace mpm {

//! A step, four points at a time; the same equations as Solver's own (solver.hpp), to rounding. Points are cut into
//! chunks by their order; each adds up what it gives on a box of nodes of its own, and nodes add the boxes in the order
//! of the chunks: no bit depends on the number of threads.
template <int D>
class PackedStep
{
 public:
    //! What the points had and have [J], plane: per metre; and what went wrong.
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

    static constexpr std::size_t chunk = 1024;           //!< points
    static constexpr std::size_t worth_sharing = 10000;  //!< nodes; threads share so many

    explicit PackedStep(int threads);
    PackedStep(PackedStep const& other);
    PackedStep& operator=(PackedStep const& other);
    PackedStep(PackedStep&&) noexcept;
    PackedStep& operator=(PackedStep&&) noexcept;
    ~PackedStep();

    //! Whether it knows all that a setup asks for.
    static bool serves(Setup<D> const& setup);

    void take(State<D> const& state) { points_.take(state); }
    void give(Setup<D> const& setup, State<D>& state) const { points_.give(state, setup.affine); }
    //! `loads`: force on each point, in the order of the state [N], plane: [N/m], or none. False: the points lie so far
    //! apart that boxes of nodes would be mostly empty; nothing was done.
    bool step(Setup<D> const& setup, double time, std::int64_t steps, double dt, std::span<Vec<D> const> loads,
              GrainContacts<D>& grains, Outcome& outcome);

 private:
    using G = packed::Given<D>;
    //! A chunk's points, the numbers on its nodes, its share of the sums.
    struct Chunk
    {
        packed::Range points;
        std::vector<double> numbers;
        Outcome outcome;
    };

    bool go(Setup<D> const& setup, double time, std::int64_t steps, double dt, std::span<Vec<D> const> loads,
            GrainContacts<D>& grains, Outcome& outcome);
    template <class Each>
    void share(std::size_t count, Each&& each);
    template <class Each>
    void each_chunk(Each&& each);
    template <class Each>
    void each_slice(Each&& each);
    void find_box(Setup<D> const& setup, Chunk& chunk, Planes<D>& box);
    bool lay_out(Setup<D> const& setup);
    void sort(Setup<D> const& setup);
    void touch_grains(Setup<D> const& setup, double time, double dt, GrainContacts<D>& grains, Outcome& outcome);
    template <bool affine, bool musl, bool shared, bool rings>
    void run(Setup<D> const& setup, double time, double dt, std::span<Vec<D> const> loads, GrainContacts<D>& grains,
             Outcome& outcome);
    template <bool affine, bool shared, bool rings, class Law>
    void deform(double dt, Law const& law);

    int threads_;
    Pace pace_;
    bool together_ = false;  //!< in this step
    std::unique_ptr<sluice::Team> team_;
    PackedPoints<D> points_;
    std::vector<Chunk> chunks_;
    std::vector<Planes<D>> boxes_;  //!< of the chunks
    PackedNodes<D> nodes_;
};

}  // namespace mpm
