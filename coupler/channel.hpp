#pragma once

#include <deque>
#include <optional>
#include <unordered_map>

#include "coupler/coupler.hpp"
#include "coupler/ledger.hpp"
#include "coupler/schedule/schedule.hpp"
#include "coupler/wire/message.hpp"
#include "coupler/work.hpp"

namespace sluice {

//! The receiving end of an edge: frames that have come from the sender's processes, in order, and the newest few for
//! prediction and sampling.
struct Samples::Source
{
    Source(Edge const& edge, int number, bool inside, DataSpec const& spec, int dimension, std::uint32_t wanted,
           std::vector<int> const& senders);

    //! Takes in a frame. Throws Error (exit 5) if it does not fit or is not the next one of its sender.
    void arrive(int member, Header const& header, Message const& message, std::string const& sender);
    bool has(std::int64_t frame, std::uint32_t iteration) const;  //!< from every process of the sender
    Frame take();                                                 //!< the oldest pending frames, as one; has() was true
    void keep(Frame frame);                                       //!< becomes the newest of the history
    void forget();                                                //!< the whole history
    //! The process of the sender that has the point `id`, as an index into its processes; -1: none has it.
    int origin_of(std::int64_t id) const;
    void set_origins(std::span<std::int64_t const> origins);  //!< of the newest frame's points
    std::vector<std::span<double const>> const& columns(double s);
    //! What a lag-1 edge is expected to bring at the window's end, from the frames before.
    std::vector<std::span<double const>> const& predicted();
    //! The guess for the points that the result has, in their order.
    void fit_guess_to_result();
    Totals const& totals(Frame& frame) const;  //!< of what adds up, summed once
    Frame const& newest() const { return guess ? *guess : history.front(); }

    Edge edge;
    InEdge terms;
    int number;  //!< of the edge in the scene
    DataSpec spec;
    int dimension;
    struct Origin
    {
        int member;  //!< process, as the transport numbers it
        FrameDecoder decoder;
        std::deque<Frame> pending = {};
        std::int64_t frame = -1;  //!< the last that came
        std::uint32_t iteration = 0;
        std::deque<SaidPower> said = {};  //!< of pending frames
    };
    std::vector<Origin> origins;
    std::deque<Frame> history;           //!< newest first, as they came
    std::optional<Frame> guess;          //!< inside a group: this window's end as it is taken to be in this iteration
    std::optional<Frame> result;         //!< inside a group, lag 1: what the sender made of it
    std::int64_t begin = 0, length = 1;  //!< of the window that is sampled, ticks
    std::optional<Account> account;      //!< of what adds up, if the scene keeps a ledger
    std::optional<Work> work;            //!< of loads: their energy
    bool looking = false;                //!< this window's samples are added up in `tally`
    Tally tally;

 private:
    Frame merged(std::vector<Frame> parts);
    std::vector<std::span<double const>> const& mix(InEdge const& by, std::span<Frame* const> frames, double s,
                                                    bool booked);
    Frame* fitted(std::size_t k, Frame& old, Frame const& newest);
    void combine(std::span<Frame* const> frames, Weights const& weights);
    void book(std::span<Frame* const> frames, Weights const& weights);

    std::unordered_map<std::int64_t, int> origin_of_;
    std::array<Frame, 3> fitted_;                        //!< frames of the history with the newest one's points
    std::array<std::int64_t, 3> fitted_to_{-1, -1, -1};  //!< which frame that was
    std::vector<std::vector<double>> mixed_;
    std::vector<std::span<double const>> spans_;
};

//! The sending end of an edge: what was written, and an encoder for each process of the receiver.
struct OutChannel
{
    struct Target
    {
        int member;  //!< process, as the transport numbers it
        FrameEncoder encoder;
        std::optional<Box> box = {};  //!< what it said that it covers
        std::int64_t used = -1;       //!< the newest frame that it has said it used

        bool takes_points() const { return !box || !box->is_empty(); }
    };

    Edge edge;
    int number;  //!< of the edge in the scene
    DataSpec spec;
    bool inside;                     //!< of an implicit group
    bool credit;                     //!< the receiver says which frames it has used
    int position = -1, radius = -1;  //!< the columns of these names; -1: none
    std::vector<Target> targets = {};
    std::int64_t written = -1;  //!< the newest frame that the solver wrote
    std::optional<Account> account = {};
    std::uint32_t iteration = 0;
    std::optional<Work> work = {};        //!< of loads: their energy
    std::vector<char> work_columns = {};  //!< that energy is reckoned with; empty: none, on this edge
    std::deque<KeptPoints> kept = {};     //!< their frames at both ends of a window that is looked at

    //! A copy of what was written: before the run begins, or until an implicit group has accepted the window.
    std::vector<std::int64_t> ids = {};
    std::vector<std::vector<double>> columns = {};

    void keep(std::span<std::int64_t const> new_ids, std::vector<std::span<double const>> const& values);
};

//! The points of a frame that one process of the receiver gets.
struct Selection
{
    std::vector<std::int64_t> ids;
    std::vector<std::vector<double>> columns;

    //! Takes those points of `frame` for which `wanted(i)` is true. `widths`: numbers a point in each column.
    template <class Wanted>
    void take(std::span<std::int64_t const> from, std::vector<std::span<double const>> const& values,
              std::vector<std::size_t> const& widths, Wanted&& wanted)
    {
        ids.clear();
        columns.resize(values.size());
        for (auto& column : columns) column.clear();
        for (std::size_t i = 0; i < from.size(); ++i) {
            if (!wanted(i)) continue;
            ids.push_back(from[i]);
            for (std::size_t c = 0; c < values.size(); ++c)
                columns[c].insert(columns[c].end(), values[c].begin() + static_cast<std::ptrdiff_t>(i * widths[c]),
                                  values[c].begin() + static_cast<std::ptrdiff_t>((i + 1) * widths[c]));
        }
    }
};

//! Whether the receiver tells the sender which frames it has used, so that a faster sender waits for it. Not needed
//! where an edge runs back: there each waits for the other in any case.
bool needs_credit(Scene const& scene, Edge const& edge);

//! Is a point, grown by its radius, inside a box or on its faces? An empty box has none.
bool reaches(Box const& box, double const* position, int dimension, double radius);

}  // namespace sluice
