#pragma once

#include <cstdint>
#include <span>
#include <vector>

//! Values from one set of points to another. Built for places that are fixed; moving points: build again.
//!
//!     Mapping const map = map_linear({grain_position, 3}, {probe_position, 3});    // from sources to targets
//!     std::vector<double> velocity = map.consistent(grain_velocity, 3);            // sources -> targets
//!     std::vector<double> force = map.conservative(probe_force, 3);                // targets -> sources, sum kept
namespace sluice {

//! N points: shape [N][dimension], interleaved [m]. Dimension 2 or 3.
struct Points
{
    std::span<double const> position;
    int dimension = 3;
};

//! A matrix M by rows, one row a target: entries begin[t] to begin[t + 1] of `source` and `weight`.
struct MappingRows
{
    std::vector<std::size_t> begin = {0};
    std::vector<std::uint32_t> source;
    std::vector<double> weight;

    std::size_t targets() const noexcept { return begin.size() - 1; }
    void end_row() { begin.push_back(weight.size()); }
};

//! M, whose rows sum to 1, and its transpose. Values are interleaved: shape [points][width]. Sums run in a fixed order,
//! so that equal input gives equal bits. All functions throw Error if a size does not fit.
class Mapping
{
 public:
    Mapping(MappingRows rows, std::size_t sources, std::size_t out_of_reach = 0);

    std::size_t sources() const noexcept { return sources_; }
    std::size_t targets() const noexcept { return rows_.targets(); }
    std::size_t entries() const noexcept { return rows_.weight.size(); }  //!< of M that are stored

    //! For densities (velocity, pressure): y = M x, at the targets. A constant stays what it is.
    //! An unmatched target gets NaN.
    std::vector<double> consistent(std::span<double const> at_sources, int width) const;
    void consistent(std::span<double const> at_sources, int width, std::span<double> at_targets) const;

    //! For amounts (force, mass): x = M^T y, at the sources. Their sum is that of y less `lost(y)`.
    std::vector<double> conservative(std::span<double const> at_targets, int width) const;
    void conservative(std::span<double const> at_targets, int width, std::span<double> at_sources) const;

    //! Targets without a source, ascending: only map_by_id knows such.
    std::span<std::size_t const> unmatched() const noexcept { return unmatched_; }
    //! Sum over the unmatched targets, `width` numbers: what `conservative` could not deliver.
    std::vector<double> lost(std::span<double const> at_targets, int width) const;
    //! Targets further from the sources than the method reaches; each method says what they get.
    std::size_t out_of_reach() const noexcept { return out_of_reach_; }

 private:
    MappingRows rows_;
    std::size_t sources_, out_of_reach_;
    std::vector<std::size_t> unmatched_;
};

// All: Error if there are targets but no sources, or a position is not finite (below 1e100 m). No targets: an empty
// map.

enum class Missing
{
    refuse,  //!< Error with the ids
    report   //!< see Mapping::unmatched()
};

//! Same id, same value. Error if two sources have one id; targets may share one.
Mapping map_by_id(std::span<std::int64_t const> sources, std::span<std::int64_t const> targets,
                  Missing missing = Missing::refuse);

//! Value of the nearest source; at equal distance that of smaller x, then y, then z, then index. First order.
//! However far a target is, it gets its nearest source.
Mapping map_nearest(Points sources, Points targets);

//! Mean over the sources nearer than `radius` [m] > 0, weighted by Wendland's C2 function (Shepard 1968). First order
//! in the radius; second where the sources are symmetric about the target. Out of reach: nobody nearer than the
//! radius; gets the nearest source.
Mapping map_kernel(Points sources, Points targets, double radius);

//! Linear fit to the 12 (2D) or 20 (3D) nearest sources, weighted by distance (moving least squares, Lancaster and
//! Salkauskas 1981). Second order; exact for linear fields, so that `conservative` keeps torque as well. Where the
//! sources lie on a line or plane, constant across it. Outside the cloud the fit is continued by at most 4 standard
//! deviations of its sources along each principal axis; out of reach: a target beyond.
Mapping map_linear(Points sources, Points targets);

struct RbfOptions
{
    int patch_points = 0;   //!< at most so many sources in a ball; 0: 50 in 2D, 80 in 3D
    double overlap = 0.15;  //!< a ball is larger than the box it must cover by this share, > 0
    double support = 3.0;   //!< radius of the basis function, in radii of the ball, > 0
};

//! Interpolates: overlapping balls, in each a linear fit plus radial basis functions (Wendland 1995, C2) for what is
//! left, blended by a partition of unity (Wendland 2002; Cavoretto and De Rossi 2015). At least second order; linear
//! fields are exact, torque is kept. Coincident sources share their value and load equally. Outside the cloud the
//! functions die off and the nearest ball's fit goes on; its reach is that of map_linear.
Mapping map_rbf(Points sources, Points targets, RbfOptions options = {});

}  // namespace sluice
