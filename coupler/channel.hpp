#pragma once

#include <deque>

#include "coupler/coupler.hpp"
#include "coupler/schedule/schedule.hpp"
#include "coupler/wire/message.hpp"

namespace sluice {

//! The receiving end of an edge: frames that have come, in order, and the newest few for prediction and sampling.
struct Samples::Source
{
    Source(Edge const& edge, int number, DataSpec const& spec, int dimension)
        : edge(edge), terms{edge.lag, edge.predict}, number(number), decoder(spec, dimension)
    {}

    void arrive(Header const& header, std::span<std::byte const> bytes, std::string const& sender)
    {
        pending.push_back(decoder.decode(header, bytes, sender));
    }
    void take_next();  //!< the oldest pending frame becomes the newest of the history
    std::vector<std::span<double const>> const& columns(double s);

    Edge edge;
    InEdge terms;
    int number;  //!< of the edge in the scene
    FrameDecoder decoder;
    std::deque<Frame> pending;
    std::deque<Frame> history;  //!< newest first; older ones rearranged into the newest one's order of points

 private:
    std::vector<std::vector<double>> mixed_;
    std::vector<std::span<double const>> spans_;
};

//! The sending end of an edge: the state that was last written, and its encoder.
struct OutChannel
{
    Edge edge;
    int number;  //!< of the edge in the scene
    FrameEncoder encoder;
    Frame frame = {};
    bool written = false;
    std::int64_t used = -1;  //!< the newest frame that the receiver has said it used
};

//! Whether the receiver tells the sender which frames it has used, so that a faster sender waits for it. Not needed
//! where an edge runs back: there each waits for the other in any case.
bool needs_credit(Scene const& scene, Edge const& edge);

}  // namespace sluice
