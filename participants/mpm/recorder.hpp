#pragma once

#include <optional>
#include <string>

#include "coupler/record/archive.hpp"
#include "coupler/record/point_series.hpp"
#include "coupler/record/run_names.hpp"
#include "coupler/record/table.hpp"
#include "participants/mpm/solver.hpp"

namespace mpm {

//! What a run leaves behind: ParaView series and HDF5 archive of the points, time series. The layout is in README.md.
template <int D>
class Recorder
{
 public:
    //! What a row says of partners.
    struct Partners
    {
        bool grains = false;  //!< with the impulse on them
        bool fluid = false;   //!< with the one of the fluid
    };

    //! A resumed run goes on with what is there up to `resumed_at` [s].
    Recorder(sluice::RunNames const& names, Partners partners, std::optional<double> resumed_at = std::nullopt);
    //! Right after the constructor: what the archive lacks of the earlier part of a resumed run; empty: nothing.
    std::string remark() const { return archive_.remark(series_.frames()); }

    void picture(double time, State<D> const& state);
    //! `balance`: of the energies at the start [J]; `impulse`: what the grains got in the last window [N s]; `fluid`:
    //! what the points got of it.
    void row(double time, Solver<D> const& solver, double front_depth, double balance, Vec<D> const& impulse,
             Vec<D> const& fluid);
    void close() { archive_.close(); }

 private:
    Partners partners_;
    sluice::PointSeries series_;
    sluice::Archive archive_;
    sluice::Table table_;
};

}  // namespace mpm
