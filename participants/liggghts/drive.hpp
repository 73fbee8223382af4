#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "participants/liggghts/engine.hpp"
#include "participants/liggghts/loads.hpp"

namespace liggghts {

//! A wall that vanishes before the step of this number.
struct Removal
{
    std::int64_t step;
    std::string fix;
};

//! What the loads of partners did to the grains; discs: per metre; 0 where nobody asks.
struct Given
{
    std::array<double, 3> impulse{};  //!< N s
    double work = 0.0;                //!< J
};

//! What somebody asks for of it.
struct Wanted
{
    bool impulse = true, work = true;
};

//! Moves the grains under loads that change from step to step. As in our DEM the load of a step acts in both its half
//! kicks. LIGGGHTS has one evaluation of forces between two steps, for the second half kick of the one and the first of
//! the other: it gets the mean of both loads, which moves the grains to the same places. At the ends of a run
//! velocities are those of our DEM, too.
class Drive
{
 public:
    //! Writes the loads of a step: in one window on the same grains in the same order.
    using LoadOfStep = std::function<void(std::int64_t step, Loads& loads)>;

    explicit Drive(Engine& engine) : engine_(engine) {}

    //! From now on the grains of the engine are driven; `applied` is what acts at first.
    void begin(Loads applied = {}, Wanted const& wanted = {});
    //! So many steps of dt [s], under the load of each, or where loads do not `vary` of the first.
    Given advance(std::int64_t steps, double dt, LoadOfStep const& load, bool vary,
                  std::vector<Removal> const& removals = {});
    Loads const& applied() const { return applied_; }  //!< at the end of the last step

 private:
    void push(Rows const& rows);
    void book_impulse(double seconds, Loads const& loads);
    void turn_to_next();

    Engine& engine_;
    Wanted wanted_;
    Loads applied_;  //!< in the evaluation of forces that is the last one
    Loads now_;      //!< of the step in progress, where they vary
    Loads next_;     //!< of the step after it
    LoadOfStep load_;
    bool vary_ = false, running_ = false;
    std::int64_t step_ = 0, steps_ = 0;
    double dt_ = 0.0;
    Given given_;
};

}  // namespace liggghts
