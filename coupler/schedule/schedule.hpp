#pragma once

#include <cstdint>
#include <optional>
#include <vector>

namespace sluice {

//! Frames of an edge are numbered by the state they describe: frame 0 is the sender's initial state (t = 0),
//! frame k its state, or its average, at the end of window k-1. A receiver in window n needs frame n+1 - lag.
struct InEdge
{
    int lag = 0;      //!< 0 or 1
    int predict = 0;  //!< order of extrapolation over the lag, 0 to 2
};

//! What a participant has to do next.
struct Action
{
    enum class Kind
    {
        send,     //!< frame `frame` on every out-edge
        await,    //!< a frame is missing on in-edge `edge`
        compute,  //!< window `window`
        finish    //!< all windows are done
    };
    Kind kind;
    std::int64_t window = 0;
    std::int64_t frame = 0;
    int edge = 0;
    bool operator==(Action const&) const = default;
};

//! One participant's part of the staggered scheme: a pure state machine, event in, action out. No I/O, no clock.
//!
//!     for (Action a = schedule.next(); a.kind != finish; a = schedule.next())
//!         send -> sent();  await -> received(edge, frame) when it has come;  compute -> computed()
class Schedule
{
 public:
    Schedule(std::vector<InEdge> in, std::int64_t windows);

    Action next() const;
    void sent();
    void computed();
    //! Returns false if `frame` is not the next one of this edge: a gap or a repetition, the caller's fatal error.
    [[nodiscard]] bool received(int edge, std::int64_t frame);

    //! The newest frame that in-edge `edge` needs in window `window`.
    std::int64_t needed(int edge, std::int64_t window) const;
    //! How many of its newest frames in-edge `edge` must keep for prediction and sampling.
    static std::int64_t kept(InEdge const& edge) { return edge.lag == 0 ? 2 : edge.predict + 1; }

 private:
    std::vector<InEdge> in_;
    std::vector<std::int64_t> arrived_;  //!< frames that have come, per in-edge: 0 .. arrived_-1
    std::int64_t windows_;
    std::int64_t window_ = 0;
    bool must_send_ = true;  //!< frame window_ is due
};

//! Coefficients of the frames n, n-1, n-2, ... (newest first) whose sum stands for the value at a time of window n.
struct Weights
{
    double at[3] = {0, 0, 0};
};

//! The value at the fraction `s` (0: begin, 1: end) of a window, as a sum over the edge's newest frames.
//! Lag 0: the newest frame is the window's end. Lag 1: the newest is its begin and the polynomial of order `predict`
//! through the newest frames is followed; with fewer frames than that the order drops (first windows).
//! `hold` is the caller's s = 1.
Weights sample_weights(InEdge const& edge, std::int64_t frames, double s);

}  // namespace sluice
