#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace liggghts {

//! The grains that LIGGGHTS has in this process, in an order that changes from run to run: views, valid until it goes
//! on.
struct Rows
{
    int count = 0;
    int const* tag = nullptr;           //!< from 1 on, lasting
    double* const* place = nullptr;     //!< three numbers a grain [m]
    double* const* velocity = nullptr;  //!< [m/s]
    double* const* spin = nullptr;      //!< [rad/s]
    double const* radius = nullptr;     //!< [m]
    double const* mass = nullptr;       //!< [kg]; in the plane per metre of thickness
    double* const* force = nullptr;     //!< all that acts [N]
    double* const* torque = nullptr;    //!< [N m]
};

//! A LIGGGHTS in this process; there can be one. It talks to its log only. Where it gives up it throws sluice::Error.
class Engine
{
 public:
    //! Called in every evaluation of forces, when velocities are those of the half step: adds what acts from outside to
    //! force and torque.
    using Push = std::function<void(Rows const& rows)>;

    //! `rank` of `ranks` processes that share the grains.
    Engine(std::filesystem::path const& log, int rank, int ranks);
    ~Engine();
    Engine(Engine const&) = delete;
    Engine& operator=(Engine const&) = delete;

    //! One command, as in an input script; `where` heads the message if it fails: "in.column:12".
    void command(std::string const& text, std::string const& where);
    //! After the last command of a script: what is called from now on, and the forces as they are.
    void couple(Push push);
    //! The forces anew, and all lists: after walls have changed.
    void evaluate();
    //! So many steps of dt [s] from where it is.
    void run(std::int64_t steps, double dt);

    Rows rows() const;

    //! By all processes that share the grains: the sum over them, in each.
    void sum(double* numbers, std::size_t count) const;
    //! The largest that one of them has, in each.
    std::int64_t largest(std::int64_t number) const;
    //! What the first of them has, in each.
    void share(std::vector<std::int64_t>& numbers) const;

    //! What run() has taken so far [s].
    struct Times
    {
        double own = 0.0;   //!< in LIGGGHTS
        double push = 0.0;  //!< in what couple() was given
    };
    Times times() const;

 private:
    struct Library;
    std::unique_ptr<Library> library_;
};

}  // namespace liggghts
