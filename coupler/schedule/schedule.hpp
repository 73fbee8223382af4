#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace sluice {

//! Frames of an edge are numbered by the state they describe: frame 0 is the sender's initial state (t = 0), frame k
//! its state, or its average, at the end of window k-1. A receiver in window n needs frame n+1 - lag.
struct InEdge
{
    int lag = 0;          //!< 0 or 1
    int predict = 0;      //!< order of extrapolation over the lag, 0 to 2
    bool inside = false;  //!< both ends are in the same implicit group: a frame comes in every iteration
};

//! What the participant that paces the run says of a window, to everybody and before it begins.
struct Plan
{
    std::int64_t window = 0;
    std::int64_t begin = 0;   //!< ticks
    std::int64_t length = 0;  //!< ticks
    bool last = false;        //!< the run ends with this window
    bool checkpoint = false;  //!< everybody stores its state before the window
    bool stop = false;        //!< and then stops instead of computing it
    bool operator==(Plan const&) const = default;
};

//! What a participant has to do next.
struct Action
{
    enum class Kind
    {
        send,        //!< frame `frame` must have been sent on every out-edge that leaves the implicit group
        plan,        //!< window `window` is to be planned (by the one who paces) or its plan is missing
        await,       //!< frame `frame` of iteration `iteration` is missing on in-edge `edge`
        checkpoint,  //!< the state before window `window` is to be stored
        compute,     //!< window `window`, for the `iteration`-th time
        agree,       //!< the group's members tell each other how far they have converged
        finish       //!< all windows are done, or the run was stopped with a checkpoint
    };
    Kind kind;
    std::int64_t window = 0;
    std::int64_t frame = 0;
    std::uint32_t iteration = 0;
    int edge = 0;
    bool operator==(Action const&) const = default;
};

//! One participant's part of the staggered scheme: a pure state machine, event in, action out. No I/O, no clock.
//!
//!     for (Action a = schedule.next(); a.kind != finish; a = schedule.next())
//!         send -> sent();  plan -> planned(plan);  await -> received(edge, frame, iteration) when it has come;
//!         checkpoint -> stored();  compute -> computed();  agree -> agreed(converged)
//!
//! When `checkpoint` is due every in-edge has brought frames 0 to `window` and no more has been taken, everywhere: the
//! states stored by all participants fit together.
class Schedule
{
 public:
    //! `grouped`: this participant is in an implicit group. `window`: the first one, after a checkpoint not 0: then the
    //! frames up to that number have been taken.
    explicit Schedule(std::vector<InEdge> in, bool grouped = false, std::int64_t window = 0);

    Action next() const;
    void sent();
    void planned(Plan const& plan);
    void stored();
    void computed();
    void agreed(bool converged);
    //! Returns false if it is not the frame that next() waits for on this edge: a gap or a repetition, the caller's
    //! fatal error.
    [[nodiscard]] bool received(int edge, std::int64_t frame, std::uint32_t iteration = 0);

    Plan const& plan() const { return plan_; }
    bool stopped() const { return planned_ && plan_.stop; }

    //! How many of its newest frames in-edge `edge` must keep for prediction and sampling.
    static std::int64_t kept(InEdge const& edge) { return edge.lag == 0 ? 2 : edge.predict + 1; }

 private:
    Action await(std::size_t edge, std::int64_t frame, std::uint32_t iteration) const;
    void go_on();

    std::vector<InEdge> in_;
    std::vector<std::int64_t> arrived_;  //!< per in-edge: frames 0 .. arrived_-1 are there and final
    std::vector<std::uint32_t>
        results_;  //!< per in-edge inside the group: iterations of frame window_+1 that are there
    bool grouped_;
    Plan plan_;
    std::int64_t window_ = 0;
    std::uint32_t iteration_ = 0;
    bool sent_ = false, planned_ = false, stored_ = false, computed_ = false, over_ = false;
};

//! Coefficients of an edge's newest frames (newest first) whose sum stands for the value at a time of a window.
struct Weights
{
    double at[3] = {0, 0, 0};
};

//! The value at the fraction `s` (0: begin, 1: end) of a window, as a sum over the edge's newest frames. `past`: how
//! long before the window's begin the frames after the newest lie, in lengths of this window (1, 2 when all are equal).
//! Lag 0, and inside a group: the newest frame is the window's end, the one before its begin. Lag 1: the newest is the
//! begin and the polynomial of order `predict` through the newest frames is followed; with fewer frames than that the
//! order drops (first windows). `hold` is the caller's s = 1.
Weights sample_weights(InEdge const& edge, std::int64_t frames, double s, std::span<double const> past);

}  // namespace sluice
