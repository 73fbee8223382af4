#pragma once

#include <memory>
#include <string>
#include <vector>

#include "coupler/scene/scene.hpp"

namespace simulation {

//! A small random scene, and what its solvers do, so that everybody knows what must come from everybody else.
//! Participant p tells of its points i at time t the number  1 + p + i/4 + (2 + p/2 + i/8) t : linear in time, so that
//! sampling and prediction are exact; and a second number that never changes, so that it is not sent again.
struct Topology
{
    struct Part
    {
        int ranks = 1;
        int points = 1;
        bool moves = false;    //!< a point belongs to the next process in the next frame
        bool changes = false;  //!< points come and go
        double step = 0;       //!< proposed, s; 0: none
    };

    explicit Topology(std::uint64_t seed);

    double value(int p, std::int64_t i, double t) const;
    //! Whether the state `frame` of process `rank` of p has point i.
    bool has(int p, int rank, std::int64_t i, std::int64_t frame) const;
    std::vector<std::int64_t> points(int p, int rank, std::int64_t frame) const;  //!< in the order in which p writes
    //! Whether process `from` of p sends point i of the state `frame` to process `to` of q.
    bool sends(int p, int from, int q, int to, std::int64_t i, std::int64_t frame) const;
    std::vector<std::int64_t> received(int p, int q, int to, std::int64_t frame) const;
    int processes() const;
    bool in_group(int p) const;

    std::string text;
    std::shared_ptr<sluice::LoadedScene const> scene;
    std::vector<Part> parts;
    std::int64_t windows = 1;  //!< how many of the first length the run has
    bool adaptive = false;     //!< the one who paces changes their length
    std::int64_t early = -1;   //!< with the window after this one it ends the run; -1: not
    bool settles = false;      //!< solvers outside groups ask whether a window stands, too
    double tolerance = 1e-9;   //!< of received values; in groups what iterations leave

 private:
    sluice::Edge const* edge(int from, int to) const;
};

}  // namespace simulation
