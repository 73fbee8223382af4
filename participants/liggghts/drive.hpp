#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "participants/dem/vec.hpp"
#include "participants/liggghts/engine.hpp"

namespace liggghts {

//! A wall that vanishes before the step of this number.
struct Removal
{
    std::int64_t step;
    std::string fix;
};

//! What the loads of partners did to the grains.
template <int D>
struct Given
{
    dem::Vec<D> impulse{};  //!< [N s]; discs: per metre; 0 where nobody asks
    double work = 0.0;      //!< [J]; 0 where nobody asks
};

//! What somebody asks for of it.
struct Wanted
{
    bool impulse = true, work = true;
};

//! Force, then torque, on one grain [N, N m].
template <int D>
using Acting = std::array<double, D == 2 ? 3 : 6>;

//! Loads in the order in which LIGGGHTS has its rows, as long as it keeps it: added without a look at the tags.
template <int D>
class LoadsInRows
{
 public:
    bool are_of(Rows const& rows) const
    {
        return std::equal(tag_.begin(), tag_.end(), rows.tag, rows.tag + rows.count);
    }
    //! The rows from now on; their loads are to be set, each.
    void begin(Rows const& rows)
    {
        tag_.assign(rows.tag, rows.tag + rows.count);
        force_.resize(3 * tag_.size());
        torque_.resize(3 * tag_.size());
    }
    void set(std::size_t row, Acting<D> const& load);
    //! As set(); the change is added to what acts on the row.
    void change(Rows const& rows, std::size_t row, Acting<D> const& load);
    //! To what acts on those rows.
    void add_to(Rows const& rows) const;

 private:
    std::vector<int> tag_;
    std::vector<double> force_, torque_;  //!< three numbers a row, in the plane as well
};

//! Moves the grains under loads that change from step to step. As in our DEM the load of a step acts in both its half
//! kicks. LIGGGHTS has one evaluation of forces between two steps, for the second half kick of the one and the first of
//! the other: it gets the mean of both loads, which moves the grains to the same places. At the ends of a run
//! velocities are those of our DEM, too.
template <int D>
class Drive
{
 public:
    //! Loads by the tag of their grain; a grain beyond the end has none.
    using Loads = std::vector<Acting<D>>;
    //! Writes the loads of a step.
    using LoadOfStep = std::function<void(std::int64_t step, Loads& loads)>;

    explicit Drive(Engine& engine) : engine_(engine) {}

    //! From now on the grains of the engine are driven; `applied` is what acts at first.
    void begin(Loads applied = {}, Wanted const& wanted = {});
    //! So many steps of dt [s], under the load of each, or where loads do not `vary` of the first.
    Given<D> advance(std::int64_t steps, double dt, LoadOfStep const& load, bool vary,
                     std::vector<Removal> const& removals = {});
    Loads const& applied() const { return applied_; }  //!< at the end of the last step

 private:
    void exchange();
    void push(Rows const& rows);
    void follow(Rows const& rows);
    void add_applied(Rows const& rows);
    void turn_to_next();

    Engine& engine_;
    Wanted wanted_;
    Loads applied_;           //!< in the evaluation of forces that is the last one
    LoadsInRows<D> in_rows_;  //!< the same, where they stay and the rows are these
    Loads now_;               //!< of the step in progress, where they vary
    Loads next_;              //!< of the step after it
    LoadOfStep load_;
    bool vary_ = false, running_ = false;
    std::int64_t step_ = 0, steps_ = 0;
    double dt_ = 0.0;
    Given<D> given_;
};

}  // namespace liggghts
