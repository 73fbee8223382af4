#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "participants/dem/config.hpp"
#include "participants/dem/solver.hpp"
#include "participants/dem/voronoi.hpp"

//! What is measured while a scene runs, as numbers and arrays with names and units.
namespace dem {

//! A vector's numbers at the end of a list.
template <class V>
void append(std::vector<double>& to, V v)
{
    each_number(v, [&](double number) { to.push_back(number); });
}

//! One time of a run, as the gauges see it.
template <int D>
class Moment
{
 public:
    //! `impulse`: that the fluid gave in the last window [N s]; `balance`: of the energies at the start [J].
    Moment(Solver<D> const& solver, Vec<D> impulse, double balance) : solver(solver), impulse(impulse), balance(balance)
    {}

    Solver<D> const& solver;
    Vec<D> const impulse;
    double const balance;
    Grains<D> const& grains() const { return solver.grains(); }
    Tessellation const& cells() const  //!< computed when it is first asked for
    {
        if (!cells_) cells_ = tessellate(solver.setup(), solver.state());
        return *cells_;
    }

 private:
    mutable std::optional<Tessellation> cells_;
};

struct Array
{
    std::string name, unit;
    std::vector<double> values;
};

//! One measure of a scene: numbers, for which the table has `columns`, and arrays, whose lengths may change.
template <int D>
struct Gauge
{
    std::vector<std::string> columns;  //!< "height [m]"
    std::function<void(Moment<D> const&, std::vector<double>& numbers, std::vector<Array>& arrays)> read;
    std::string name = {};  //!< of the measure, as in the scene
    double interval = 0.0;  //!< its own [s]; 0: that of the time series
};

//! The measures that a scene wants, in the order of their names. `mean_diameter` [m].
template <int D>
std::vector<Gauge<D>> gauges_of(Config const& config, double mean_diameter);

}  // namespace dem
