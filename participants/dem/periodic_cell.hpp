#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "participants/dem/vec.hpp"

//! A cell whose sides continue at the opposite ones. Its images lie at n.h, h its edges; a listed pair keeps which
//! image of its second grain it sees. Under shear (Lees and Edwards, J. Phys. C 5 (1972) 1921) and where the height
//! follows a pressure, the images move: a grain that is put back on the other side changes its velocity with its place.
namespace dem {

//! Simple shear: the velocity along one axis grows by `rate` with each metre of another.
struct Shear
{
    int along = 0, across = 1;  //!< axes
    double rate = 0.0;          //!< [1/s]; 0: none
    double pressure = 0.0;      //!< normal stress that the height across follows [Pa]; 0: it stays
    double impedance = 0.0;     //!< stress that is missing for each m/s of the height [Pa s/m]
    double steady_from = 0.0;   //!< shear strain after which it is taken to be steady [-]
};

//! Periodic sides, as they are at the start.
template <int D>
struct Periodic
{
    std::array<bool, D> axis{};  //!< which axes
    Vec<D> low, extent;          //!< [m]; of the periodic axes
    Shear shear;

    bool any() const noexcept
    {
        bool yes = false;
        for (bool const periodic : axis) yes = yes || periodic;
        return yes;
    }
    bool is_sheared() const noexcept { return shear.rate != 0.0; }
};

//! Images are numbered (nx + 1) + 3 (ny + 1) + 9 (nz + 1), n from -1 to 1.
template <int D>
inline constexpr std::size_t image_count = D == 2 ? 9 : 27;
template <int D>
inline constexpr std::uint32_t home = image_count<D> / 2;
//! The part of an image's n along an axis.
constexpr int image_number(std::size_t image, int axis) noexcept
{
    for (; axis > 0; --axis) image /= 3;
    return static_cast<int>(image % 3) - 1;
}

//! Whether there is such an image where only some axes are periodic.
template <int D>
bool has_image(Periodic<D> const& periodic, std::size_t image) noexcept
{
    bool yes = true;
    for (int k = 0; k < D; ++k)
        yes = yes && (periodic.axis[static_cast<std::size_t>(k)] || image_number(image, k) == 0);
    return yes;
}

//! An image of the cell, as rows of 32 bytes.
template <int D>
struct Image
{
    alignas(32) Vec<D> shift;     //!< from a grain to its image [m]
    alignas(32) Vec<D> velocity;  //!< of the image less that of the grain, over the last step [m/s]
    alignas(32) Vec<D> through;   //!< force of all pairs that see this image on their first grains [N]
};

//! The cell as it is now.
template <int D>
struct Cell
{
    Vec<D> extent;               //!< [m]
    double offset = 0.0;         //!< of the upper image, along the shear [m]
    double slide = 0.0;          //!< its speed over the last step [m/s]
    double growth = 0.0;         //!< of the height across, over the last step [m/s]
    double strain = 0.0;         //!< shear strain since the start [-]
    double built_offset = 0.0;   //!< when the lists were built [m]
    double built_height = 0.0;   //!< across, when the lists were built [m]
    std::array<Vec<D>, D> pull;  //!< sum of n times the force of a pair on its first grain, for each axis [N]
    std::array<Image<D>, image_count<D>> images;  //!< follow from the above
};

//! An edge of the cell: what carries a grain to its next image along an axis [m].
template <int D>
Vec<D> edge_of(Periodic<D> const& periodic, Cell<D> const& cell, int axis) noexcept
{
    Vec<D> edge;
    component<D>(edge, axis) = component(cell.extent, axis);
    if (periodic.is_sheared() && axis == periodic.shear.across) component<D>(edge, periodic.shear.along) = cell.offset;
    return edge;
}

//! How fast that edge changes [m/s].
template <int D>
Vec<D> edge_rate_of(Periodic<D> const& periodic, Cell<D> const& cell, int axis) noexcept
{
    Vec<D> rate;
    if (!periodic.is_sheared() || axis != periodic.shear.across) return rate;
    component<D>(rate, axis) = cell.growth;
    component<D>(rate, periodic.shear.along) = cell.slide;
    return rate;
}

//! The cell at the start.
template <int D>
Cell<D> cell_at_start(Periodic<D> const& periodic) noexcept;

//! Shifts and velocities of the images from what the cell is.
template <int D>
void place_images(Periodic<D> const& periodic, Cell<D>& cell) noexcept;

//! A cell as it was when the lists were built.
template <int D>
void set_as_built(Periodic<D> const& periodic, Cell<D>& cell) noexcept;

//! The cell one step of dt [s] later; `stress` is what presses across now [Pa], looked at where a pressure is asked
//! for. The height moves as a plate would that takes up sound: by the missing stress over an impedance; never faster
//! than at no stress at all.
template <int D>
void advance_cell(Periodic<D> const& periodic, Cell<D>& cell, double dt, double stress) noexcept;

//! Power of the pairs that see moving images [W].
template <int D>
double pulling_power(Periodic<D> const& periodic, Cell<D> const& cell) noexcept;

//! By how much an image may have come nearer since the lists were built [m].
template <int D>
double moved_since_built(Periodic<D> const& periodic, Cell<D> const& cell) noexcept;

//! The sums over images that follow from `through` of each.
template <int D>
void gather_pull(Cell<D>& cell) noexcept;

}  // namespace dem
