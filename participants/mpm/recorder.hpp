#pragma once

#include <optional>
#include <string>

#include "coupler/record/archive.hpp"
#include "coupler/record/point_series.hpp"
#include "coupler/record/run_names.hpp"
#include "coupler/record/table.hpp"
#include "participants/mpm/solver.hpp"

namespace mpm {

//! Columns of the time series that not every run has.
struct Extras
{
    bool field_work = false;  //!< the rate of the frame changes, or sides are joined
    bool grains = false;      //!< the impulse on those of a partner
    bool fluid = false;       //!< the impulse of a partner's fluid
    bool rings = false;       //!< energies are of whole rings
};

//! What a run leaves behind: ParaView series and HDF5 archive of the points, time series. The layout is in README.md.
template <int D>
class Recorder
{
 public:
    //! A resumed run goes on with what is there up to `resumed_at` [s].
    Recorder(sluice::RunNames const& names, Extras extras, std::optional<double> resumed_at = std::nullopt);
    //! Right after the constructor: what the archive lacks of the earlier part of a resumed run; empty: nothing.
    std::string remark() const { return archive_.remark(series_.frames()); }

    void picture(double time, State<D> const& state);
    //! `balance`: of the energies at the start [J]; `impulse`: what the grains got in the last window [N s]; `fluid`:
    //! what the points got of it.
    void row(double time, Solver<D> const& solver, double front_depth, double balance, Vec<D> const& impulse,
             Vec<D> const& fluid);
    void close() { archive_.close(); }

 private:
    Extras extras_;
    sluice::PointSeries series_;
    sluice::Archive archive_;
    sluice::Table table_;
};

}  // namespace mpm
