#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "coupler/base/team.hpp"
#include "participants/lbm/domain.hpp"
#include "participants/lbm/lattice.hpp"
#include "participants/lbm/shared_runs.hpp"
#include "participants/lbm/strip.hpp"

namespace lbm {

//! A solid at rest that is no body: its fractions of the cells of a box, lattice units. What lies outside the lattice
//! is cut off.
template <int D>
struct Patch
{
    Extent first{}, size{};          //!< lowest cell, and cells along x, y, z
    std::vector<double> fraction{};  //!< shape [z][y][x]
    std::array<double, D> centre{};  //!< torques are about it
    double drag = 0;                 //!< K of its surface, solid_weight.hpp

    //! The fractions of a row of the lattice; nullptr: it has none.
    double const* row(std::ptrdiff_t y, std::ptrdiff_t z) const noexcept
    {
        y -= first[1], z -= first[2];
        if (y < 0 || y >= size[1] || z < 0 || z >= size[2]) return nullptr;
        return fraction.data() + (z * size[1] + y) * size[0];
    }
};

//! Which body covers how much of which cell; bodies that did not move keep their strips.
template <int D>
class Coverage
{
 public:
    //! Keeps the domain's address, and of the patches what lies in cells that are stored.
    Coverage(Domain<D> const& domain, std::array<bool, 3> periodic, std::vector<Patch<D>> patches = {});

    //! What is left of a patch in the whole lattice.
    struct Kept
    {
        std::array<double, D> centre;
        double volume = 0;                     //!< [cells]
        std::array<double, D> first_moment{};  //!< of the volume, about the centre [cells^2]
        std::array<std::ptrdiff_t, 2> layers;  //!< begin and end
    };
    std::vector<Kept> const& patches() const noexcept { return patches_; }
    //! Returns how many bodies' fractions it computed anew.
    std::ptrdiff_t update(std::span<Body<D> const> bodies, sluice::Team& team);

    //! Indices into strips() of the strips in a row, by body.
    std::span<std::uint32_t const> row(std::ptrdiff_t r) const noexcept;
    std::span<Strip<D> const> strips() const noexcept { return strips_; }
    //! Begin and end in strips() of body i's strips, from the lowest row up; after the bodies come the patches.
    std::array<std::size_t, 2> of_body(std::size_t i) const noexcept { return {first_[i], first_[i] + count_[i]}; }
    //! Whether this process has all layers that body i, or patch, may reach.
    bool has_all_of(std::size_t i) const noexcept;
    std::size_t bytes() const noexcept
    {
        return sizeof(double) * listed_.size() + patch_fraction_.bytes() +
               sizeof(Strip<D>) * (strips_.size() + patch_strips_.size());
    }

 private:
    struct Shape
    {
        std::array<double, D> centre;
        double radius;
        bool operator==(Shape const&) const = default;
        //! Begin and end of the layers that it may reach; beyond the lattice if it does.
        std::array<std::ptrdiff_t, 2> layers() const noexcept
        {
            return {static_cast<std::ptrdiff_t>(std::floor(centre[D - 1] - radius)) - 1,
                    static_cast<std::ptrdiff_t>(std::ceil(centre[D - 1] + radius)) + 1};
        }
    };

    void lay_out(std::span<Body<D> const> bodies);
    void add_patch(Patch<D> const& patch, std::vector<std::size_t>& offsets);
    bool is_near(Shape const& shape) const noexcept;
    void cover(std::size_t i, Body<D> const& body);
    std::size_t add_strips(std::size_t first, Strip<D> const& strip, Extent const& at);
    std::size_t add_within_lattice(std::size_t first, Strip<D> const& strip, Extent const& at);
    void sort_by_row();

    Domain<D> const* domain_;
    Layout const* layout_;  //!< of this process
    std::array<bool, 3> periodic_;
    std::vector<Shape> shape_;                       //!< of the bodies at the last update
    std::vector<std::size_t> list_start_;            //!< in listed_, for each body
    std::vector<std::size_t> first_, count_, room_;  //!< of each body's strips
    std::vector<double> listed_;                     //!< fractions, see RowCover
    std::vector<Kept> patches_;
    SharedRuns<double> patch_fraction_;
    std::vector<Strip<D>> patch_strips_;       //!< `body`: which patch
    std::vector<std::size_t> patch_start_{0};  //!< in patch_strips_, and its end
    std::vector<Strip<D>> strips_;
    std::vector<std::uint32_t> row_of_strip_;  //!< side by side, to be sorted by
    std::vector<std::uint32_t> by_row_, row_start_;
};

}  // namespace lbm
