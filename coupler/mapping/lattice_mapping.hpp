#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

//! Moving points to a uniform lattice and back. Each window:
//!
//!     map.place(grain_position);                                          // weights, once for all columns
//!     map.gather(fluid_velocity, 3, grain_fluid_velocity);                // consistent: lattice -> points
//!     std::vector<double> const lost = map.spread(grain_force, 3, force); // conservative: points -> lattice
namespace sluice {

//! Cell (i, j, k) is number i + nx (j + ny k); its values stand for its centre, origin + (i + 1/2, ...) spacing.
struct Lattice
{
    int dimension = 3;
    std::array<double, 3> origin = {};              //!< m, lower corner of cell (0, 0, 0)
    double spacing = 1;                             //!< m
    std::array<std::int64_t, 3> cells = {1, 1, 1};  //!< nx, ny, nz; nz is not looked at in 2D
    std::size_t size() const noexcept;              //!< number of cells
};

//! Product of one function an axis; sum over the cells is 1 and the first moment is exact wherever the point is.
enum class LatticeKernel
{
    hat,          //!< multilinear, 2 cells an axis
    three_point,  //!< Roma, Peskin and Berger, J. Comput. Phys. 153 (1999), eq. 22
    four_point    //!< Peskin, Acta Numerica 11 (2002), eq. 6.27
};

//! What a weight on a cell beyond the border becomes.
enum class Border
{
    mirror,  //!< that of the cell's mirror image: no weight is negative, right for a mass or volume
    linear   //!< values continued linearly: keeps linear fields and torque up to the border; weights down to -1/2
};

//! Places of points on a lattice. A point is inside if it lies in the cells' box, to 1e-9 of a spacing. Values are
//! interleaved: [cell][width] and [point][width]; a lattice that keeps components apart calls once for each. Sums run
//! in a fixed order: equal input gives equal bits. Sizes that do not fit: Error.
class LatticeMapping
{
 public:
    //! Error if spacing is not > 0, an axis has fewer cells than the kernel (2, 3, 4) or the number of cells is absurd.
    explicit LatticeMapping(Lattice const& lattice, LatticeKernel kernel, Border border = Border::mirror);

    //! Where the points are now, [N][dimension] [m]. Error if a position is not finite.
    void place(std::span<double const> position);

    std::size_t points() const noexcept { return first_.size(); }
    std::span<std::size_t const> outside() const noexcept { return outside_; }  //!< points, ascending

    //! y = S x; a point outside gets 0.
    void gather(std::span<double const> at_cells, int width, std::span<double> at_points) const;
    //! x += S^T y. Returns the sum over the points outside, `width` numbers: the sum of y less that of what was added.
    std::vector<double> spread(std::span<double const> at_points, int width, std::span<double> at_cells) const;

 private:
    template <int D, LatticeKernel K>
    void place_all(std::span<double const> position);

    Lattice lattice_;
    LatticeKernel kernel_;
    Border border_;
    std::vector<std::int64_t> first_;  //!< lowest cell of each point's block of cells; -1: outside
    std::vector<double> weight_;       //!< [point][axis][cell along the axis]
    std::vector<std::size_t> outside_;
};

}  // namespace sluice
