#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "participants/mpm/borders.hpp"
#include "participants/mpm/pace.hpp"
#include "participants/mpm/packed_nodes.hpp"
#include "participants/mpm/shared_points.hpp"

namespace sluice {
class Team;
}

namespace mpm {

//! A step, four points at a time; the same equations as Solver's own (solver.hpp), to rounding. Points are cut into
//! chunks by their order; each adds up what it gives on a box of nodes of its own, and nodes add the boxes in the order
//! of the chunks: no bit depends on the number of threads, nor on that of processes, each of which has some chunks, and
//! all nodes that its points reach.
template <int D>
class PackedStep
{
 public:
    //! What the points of all processes had and have [J], plane: per metre; and what went wrong.
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

    static constexpr std::size_t chunk = Shares::chunk;  //!< points
    static constexpr std::size_t worth_sharing = 10000;  //!< nodes; threads share so many
    static constexpr std::int64_t sorted_every = 32;     //!< steps; 8 to 128 are within 2 %

    //! `peers`: the processes that share the points, all of which make the same calls; null: there is one.
    explicit PackedStep(int threads, ranks::Peers* peers = nullptr);
    PackedStep(PackedStep const& other);
    PackedStep& operator=(PackedStep const& other);
    PackedStep(PackedStep&&) noexcept;
    PackedStep& operator=(PackedStep&&) noexcept;
    ~PackedStep();

    //! Whether it knows all that a setup asks for.
    static bool serves(Setup<D> const& setup);

    //! Of a state that each process has, its share.
    void take(State<D> const& state);
    //! All points, to those that are to have them.
    void give(Setup<D> const& setup, State<D>& state, Whom whom) const;
    //! Places and velocities, to the first of several processes.
    void give_motion(State<D>& state) const { gather_motion(shares_, points_, state); }
    //! Puts the points of all in the order of their cells, in tiles.
    void sort(Setup<D> const& setup);
    //! `loads`: force on each point, in the order of the state [N], plane: [N/m], or none. False: the points lie so far
    //! apart that boxes of nodes would be mostly empty; nothing was done.
    bool step(Setup<D> const& setup, double time, double dt, std::span<Vec<D> const> loads, GrainContacts<D>& grains,
              Outcome& outcome);

 private:
    using G = packed::Given<D>;
    //! A chunk's points, the numbers on its nodes, its share of the sums.
    struct Chunk
    {
        packed::Range points;
        std::vector<double> numbers;
        Outcome outcome;
    };
    //! What a step is given.
    struct Given
    {
        Setup<D> const& setup;
        double time, dt;
        std::span<Vec<D> const> loads;
        Field<D> field{setup, time, dt};
        Shape shape{setup.basis == BasisKind::spline ? 0.5 : setup.half_width, setup.origin[0] / setup.cell};

        bool loaded() const { return !loads.empty(); }
        //! Numbers of a node, from its mass on, that points give before it moves.
        std::size_t planes() const { return loaded() ? std::size_t{G::volume} : std::size_t{G::again}; }
    };

    bool go(Given const& now, GrainContacts<D>& grains, Outcome& outcome);
    template <class Each>
    void share(std::size_t count, Each&& each);
    template <class Each>
    void each_chunk(Each&& each);
    template <class Each>
    void each_slice(Each&& each);
    NodeBox<D> find_box(Setup<D> const& setup, Chunk& chunk);
    bool lay_out(Setup<D> const& setup);
    std::span<Planes<D>> own_boxes() { return {boxes_.data() + borders_.before().size(), chunks_.size()}; }
    void share_boxes(std::size_t from, std::size_t count);
    void touch_grains(Given const& now, GrainContacts<D>& grains, Outcome& outcome);
    void share_touched(std::span<TouchedNode<D>> touched) const;
    template <bool affine, bool musl, bool shared, bool rings>
    void run(Given const& now, GrainContacts<D>& grains, Outcome& outcome);
    void share_means();
    template <bool shared, bool rings>
    void begin_boxes();
    template <bool affine, bool shared, bool rings>
    void give_to_nodes(Given const& now);
    void move_nodes(Given const& now, GrainContacts<D>& grains, Outcome& outcome);
    template <bool affine, bool musl, bool rings>
    void move_points(Given const& now);
    template <bool musl>
    bool set_strain_velocities(Setup<D> const& setup);
    template <bool musl, bool shared, bool rings>
    void find_gradients(Given const& now, bool gathered);
    template <bool affine, bool shared, bool rings, class Law>
    void deform(double dt, Law const& law);
    void book_potential(Setup<D> const& setup, double time, double sign);
    void add_up(Outcome& outcome);

    int threads_;
    ranks::Peers* peers_;
    Pace pace_;
    bool together_ = false;  //!< in this step
    std::unique_ptr<sluice::Team> team_;
    Shares shares_;
    PackedPoints<D> points_;
    std::vector<Chunk> chunks_;
    std::vector<Planes<D>> boxes_;  //!< of the chunks, in their order; those of others, too, as far as they matter here
    PackedNodes<D> nodes_;
    Borders<D> borders_;
};

}  // namespace mpm
