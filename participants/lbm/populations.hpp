#pragma once

#include <array>
#include <cstddef>
#include <cstdlib>
#include <memory>

#include "coupler/base/team.hpp"
#include "participants/lbm/d2q9.hpp"

namespace lbm {

using Slots = std::array<double*, directions>;  //!< for each direction the slot of cell x = 0 of one row

//! The populations f_q - w_q [-], one array for each direction, shape [q][y][x], x fastest, with one ghost cell all
//! round.
//!
//! Streaming moves no data. A cell's post-collision value stays in its slot and the array's origin moves by -c_q, so
//! that the neighbour at +c_q finds it where it looks for its own:
//!     slot of (x, y) at step t  =  start_q + (y stride + x) - t (cy_q stride + cx_q)
//! Each array has slack at the end toward which the origin moves; when it is used up the array is moved back
//! (about 1 % of the time). Every cell reads and writes its own slots only: no order, no races, no second array.
class Populations
{
 public:
    Populations(std::ptrdiff_t nx, std::ptrdiff_t ny, sluice::Team& team);  //!< all slots 0: fluid of density 1 at rest

    std::ptrdiff_t nx() const noexcept { return nx_; }
    std::ptrdiff_t ny() const noexcept { return ny_; }
    std::ptrdiff_t stride() const noexcept { return stride_; }  //!< from one row to the next

    //! Slot of direction q of cell (0, y); valid for -1 <= x <= nx, -1 <= y <= ny until the next stream().
    double* row(std::size_t q, std::ptrdiff_t y) noexcept { return origin_[q] + y * stride_; }
    double const* row(std::size_t q, std::ptrdiff_t y) const noexcept { return origin_[q] + y * stride_; }
    Slots row(std::ptrdiff_t y) noexcept;

    void stream(sluice::Team& team);  //!< one step: every population moves by c_q

    std::size_t bytes() const noexcept { return bytes_; }

 private:
    struct Free
    {
        void operator()(double* p) const noexcept { std::free(p); }
    };

    std::ptrdiff_t shift(std::size_t q) const noexcept { return cx[q] + cy[q] * stride_; }

    std::ptrdiff_t nx_, ny_, stride_, slack_;
    std::size_t bytes_ = 0;
    std::unique_ptr<double, Free> memory_;
    Slots start_{};   //!< origin of each array when its slack is whole
    Slots origin_{};  //!< slot of cell (0, 0) now
};

}  // namespace lbm
