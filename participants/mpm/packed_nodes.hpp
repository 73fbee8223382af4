#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "participants/mpm/exact_sum.hpp"
#include "participants/mpm/grains.hpp"
#include "participants/mpm/packed_passes.hpp"

namespace mpm {

//! What chunks gave, on all nodes, and what becomes of these; the same equations as Solver's own. Nodes lie in slices
//! across the last axis: what is done to a slice needs no other.
template <int D>
class PackedNodes
{
 public:
    //! Of a slice, of all, or of all that several processes have.
    struct Sums
    {
        ExactSum damped, sliding, external;   //!< energy taken, work done [J]; plane: per metre
        std::int64_t light = 0, reached = 0;  //!< nodes

        void add(Sums const& other)
        {
            damped.add(other.damped), sliding.add(other.sliding), external.add(other.external);
            light += other.light, reached += other.reached;
        }
    };

    //! A box of nodes. What is on them is not defined until a slice is worked on. Across joined sides nodes a domain
    //! apart are one: each of them has all that is given to any, so that points need not go round.
    void lay_out(Planes<D> const& box, Setup<D> const& setup);
    //! Sums leave out nodes that lie in these boxes, too: others have counted them.
    void leave_out(std::span<NodeBox<D> const> boxes);
    Planes<D> const& planes() const { return planes_; }
    //! Ways to the nodes that are the same, none included, in the order in which they are added.
    std::span<std::array<int, D> const> rounds() const { return rounds_; }
    std::size_t slices() const { return slices_.size(); }
    Sums sums() const;

    //! Planes of all chunks' boxes, one after the other, of one slice.
    void add(std::size_t slice, std::span<Planes<D> const> boxes, std::size_t from, std::size_t count);
    void take_mean(std::size_t slice);
    //! What lies on the planes of the second momentum is a force.
    void add_loads(std::size_t slice);
    template <bool turning>
    void move(std::size_t slice, Setup<D> const& setup, Field<D> const& field, double dt);
    //! Work of the loads, after move().
    void book_loads(std::size_t slice, Setup<D> const& setup, double dt);
    //! Fills in what contacts have to know of their nodes, and takes over what they made of them; of those here.
    void show(std::span<TouchedNode<D>> touched) const;
    void take(std::span<TouchedNode<D> const> touched);
    void hold(std::size_t slice, Setup<D> const& setup, double time, double dt);
    //! Of the second momentum; a light node has no other.
    void set_strain_velocities(std::size_t slice);
    //! A node of almost no mass is seen by strain at the velocity that the points brought.
    void pass_light_nodes(std::size_t slice, Setup<D> const& setup);

 private:
    using T = packed::Taken<D>;
    struct Gripped
    {
        std::size_t node;
        int axis;
        Grip grip;
    };
    struct Slice
    {
        std::size_t begin = 0, end = 0;  //!< nodes
        Sums sums;
        std::vector<Gripped> gripped;
    };

    Vec<D> vector_at(std::size_t plane, std::size_t node) const
    {
        Vec<D> v;
        for (int a = 0; a < D; ++a) v[a] = planes_[plane + static_cast<std::size_t>(a)][node];
        return v;
    }
    void set(std::size_t plane, std::size_t node, Vec<D> const& v)
    {
        for (int a = 0; a < D; ++a) planes_[plane + static_cast<std::size_t>(a)][node] = v[a];
    }
    void hold_node(std::size_t node, Wall const& wall, Slice& slice);
    void book_damping(Slice& slice, double share) const;
    void add_box(int line, Planes<D> const& box, std::array<int, D> const& round, std::size_t from, std::size_t count);
    //! Whether sums take a node: of those that are the same, here or with others, one.
    bool counts(std::size_t node) const { return counted_.empty() || counted_[node] != 0; }

    Planes<D> planes_;
    std::array<int, D> period_{};  //!< of joined sides, in nodes; 0: none
    std::vector<std::array<int, D>> rounds_;
    std::vector<char> counted_;  //!< of each node; none: all are
    std::vector<double> numbers_;
    std::vector<Slice> slices_;
};

}  // namespace mpm
