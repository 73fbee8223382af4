#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "coupler/scene/scene.hpp"

namespace sluice {

//! Sums over all points of what adds up (forces, torques, volumes, masses): one number for each component of each such
//! column.
using Totals = std::vector<double>;

//! Does a column hold an amount, whose sum over points means something? By its unit.
bool is_amount(ColumnSpec const& column);
Totals totals_of(DataSpec const& spec, int dimension, std::vector<std::span<double const>> const& columns);

//! The books of one edge at one end. The receiver compares, window by window, what came with what its solver took: the
//! mean of its samples. With prediction and interpolation a part is under way from one window to the next, never more
//! than a few windows' worth; what is missing beyond that was lost (a load that nobody reads) or made. The sender
//! compares what its solver wrote with what was sent to all processes of the receiver and what lay outside their boxes.
class Account
{
 public:
    Account(DataSpec const& spec, int dimension, std::string name);
    bool empty() const { return labels_.empty(); }  //!< nothing on this edge adds up

    //! Receiver: a frame that is used in this window, a sample, and the end of a window of `length` seconds.
    void came(Totals const& totals);
    void taken(Totals const& totals);
    void close(double length);
    void forget_samples();  //!< the window is computed again

    //! Sender: one frame, as written, as sent to all processes, and left out.
    void sent(Totals const& written, Totals const& sent, Totals const& outside);

    //! What does not close within `tolerance` (relative to all that came), as text; empty: everything does.
    std::string violation(double tolerance) const;
    nlohmann::ordered_json summary() const;

 private:
    struct Book
    {
        double came = 0, taken = 0;     //!< so far: times seconds for the receiver, plain sums for the sender
        double moved = 0, largest = 0;  //!< sum and largest of |came|
        double frame = 0, samples = 0;  //!< of this window
        double outside = 0;             //!< sender: not sent, nobody covers the place
    };

    std::string name_;
    std::vector<std::string> labels_;  //!< "force_x [N]"
    std::vector<Book> books_;
    int sampled_ = 0;
    bool sender_ = false;
    std::int64_t windows_ = 0;
};

}  // namespace sluice
