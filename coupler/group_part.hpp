#pragma once

#include "coupler/base/state.hpp"
#include "coupler/channel.hpp"
#include "coupler/schedule/acceleration.hpp"

namespace sluice {

struct Member;

//! What one process holds of an implicit group: the unknowns are the numbers that come back with lag 1, each receiver
//! holds its own, and all decide alike from small summaries. Moves no messages.
class GroupPart
{
 public:
    //! `in`: the process's in-edges; they outlive this.
    GroupPart(Scene const& scene, ImplicitGroup const& group, std::vector<Member> const& members, int self,
              std::vector<Samples::Source>& in);

    bool has_unknowns() const { return !blocks_.empty(); }
    std::vector<int> const& owners() const { return owners_; }  //!< per block of the group: the member that holds it

    //! Before the first iteration: the lag-1 edges are taken to bring what is predicted.
    void begin_window(Plan const& plan);
    //! What this process tells the others about its unknowns: per block its number, its length, its summary. Throws
    //! Error (exit 5) that ends with `where` if the points of a block have changed since the last iteration.
    std::vector<double> summarize(std::uint32_t iteration, std::string const& where);
    //! Takes in what `member` said. False: it does not fit.
    bool hear(int member, std::vector<double> const& numbers);
    Verdict judge() const;  //!< of all blocks, once everybody was heard
    void improve();         //!< the guesses for the next iteration
    void stand();           //!< the window stands: the last iteration's frames become history

    //! "force.x 0.01, ...": by column, how far the last iteration was from agreement.
    std::string residuals(Verdict const& verdict) const;

    void put(State& state) const;
    void take(State const& state);

 private:
    struct Block
    {
        std::size_t channel;  //!< index into `in`
        int number;           //!< in the group
        AccelerationBlock numerics;
    };

    std::vector<Samples::Source>& in_;
    AccelerationConfig config_;
    std::vector<Block> blocks_;
    std::vector<int> owners_;
    std::vector<std::vector<double>> summaries_;  //!< per block of the group, of this iteration
};

}  // namespace sluice
