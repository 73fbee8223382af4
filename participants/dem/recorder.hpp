#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "coupler/record/archive.hpp"
#include "coupler/record/point_series.hpp"
#include "coupler/record/run_names.hpp"
#include "coupler/record/table.hpp"
#include "participants/dem/gauges.hpp"

namespace dem {

//! The grains as columns for frames, files and archives: interleaved, as all of those want them.
template <int D>
struct Columns
{
    std::vector<std::int64_t> id;
    std::vector<double> position, velocity, spin, radius, force;

    void update(Grains<D> const& grains);
};

//! What is to be recorded at one time.
struct Due
{
    double time;                         //!< [s]
    bool picture, series;                //!< by the intervals of the scene
    std::function<bool(double)> others;  //!< whether it is one of the times of another interval [s]
};

//! Whether there is anything to record at that time.
bool is_anything_due(MeasuresConfig const& measures, Due const& due);

//! What a run leaves behind: ParaView series, HDF5 archives, tables. The layout is in README.md.
template <int D>
class Recorder
{
 public:
    //! `mean_diameter` [m]. A resumed run goes on with what is there up to `resumed_at` [s].
    Recorder(sluice::RunNames const& names, Config const& config, double mean_diameter,
             std::optional<double> resumed_at = std::nullopt);
    //! Right after the constructor: what the archives lack of the earlier part of a resumed run; empty: nothing.
    std::string remark() const { return archive_.remark(series_.frames()); }

    void record(Due const& due, Columns<D> const& columns, Moment<D> const& now);
    void close();

 private:
    struct Part;
    void picture(double time, Columns<D> const& columns, Moment<D> const& now);
    void read_gauges(Due const& due, Moment<D> const& now, std::vector<Part>& parts);
    void read_contacts(double time, Moment<D> const& now, std::vector<Part>& parts);

    MeasuresConfig measures_;
    std::vector<Gauge<D>> gauges_;
    sluice::PointSeries series_;
    sluice::Archive archive_;
    sluice::Table table_;
    std::vector<std::unique_ptr<sluice::Table>> own_;  //!< of the gauges with an interval and columns; else null
    std::optional<sluice::PointSeries> chains_;
    std::optional<sluice::Archive> measured_;  //!< what the key `measures` names
};

}  // namespace dem
