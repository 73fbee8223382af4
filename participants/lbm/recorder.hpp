#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "coupler/record/archive.hpp"
#include "coupler/record/image_series.hpp"
#include "coupler/record/run_names.hpp"
#include "coupler/record/table.hpp"
#include "participants/lbm/solver.hpp"

namespace lbm {

//! One row of the time series, SI.
template <int D>
struct Measured
{
    double max_speed, mass;
    std::array<double, D> momentum;
    std::array<double, D> impulse;  //!< what the fluid gave to all grains in the last window [N s]
    std::vector<double> on_solids;  //!< mean force on each solid at rest in that window [N]
    std::optional<Energies> energies{};
    std::vector<Sample<D>> probes{};
    std::vector<std::vector<Sample<D>>> lines{};
};

//! What the configuration asks for of the fluid as it is now. Called by all processes.
template <int D>
Measured<D> measured(Solver<D>& solver, std::array<double, D> const& impulse, std::vector<double> const& on_solids);

//! What a run leaves behind: ParaView series, HDF5 archive, time series. The layout is in README.md.
template <int D>
class Recorder
{
 public:
    //! A resumed run goes on with what is there up to `resumed_at` [s]. Keeps the configuration's address.
    Recorder(sluice::RunNames const& names, Config const& config, int coarsen,
             std::optional<double> resumed_at = std::nullopt);
    //! Right after the constructor: what the archive lacks of the earlier part of a resumed run; empty: nothing.
    std::string remark() const { return archive_.remark(series_.frames()); }

    void picture(double time, Fields const& fields);
    void row(double time, Measured<D> const& now);
    void close() { archive_.close(); }

 private:
    Config const& config_;
    sluice::Lattice lattice_;
    sluice::ImageSeries series_;
    sluice::Archive archive_;
    sluice::Table table_;
    std::vector<std::unique_ptr<sluice::Table>> lines_;
};

}  // namespace lbm
