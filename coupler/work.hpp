#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "coupler/base/frame.hpp"
#include "coupler/scene/scene.hpp"

//! The energy that loads carry: force times velocity and torque times angular velocity, point by point.
namespace sluice {

//! A column of a load and the column of a motion that it makes power with: N with m/s, N m with rad/s.
struct PowerPair
{
    std::size_t load, motion;  //!< columns of the two data
    std::size_t width;         //!< numbers a point in each
    std::string label;         //!< "force x velocity"
};
std::vector<PowerPair> power_pairs(DataSpec const& load, DataSpec const& motion, int dimension);

//! The edge that tells the sender of `load` how the points move that its loads act on: the first one back that carries
//! what makes power. Indices into Scene::edges; -1: there is none, or the load comes from several processes and
//! does not add up.
int motion_edge(Scene const& scene, int load);

//! Whether work is reckoned in this window: every so many.
inline bool is_looked_at(std::int64_t window, std::int64_t every)
{
    return every > 0 && window >= 0 && window % every == every - 1;
}

//! Points and what they carry, interleaved; somebody else holds the numbers.
struct PointsView
{
    std::span<std::int64_t const> ids;
    std::vector<std::span<double const>> columns;
};
PointsView view_of(Frame const& frame);

//! The same, held here.
struct KeptPoints
{
    std::int64_t index = -1;  //!< of the frame
    std::vector<std::int64_t> ids;
    std::vector<std::vector<double>> columns;

    PointsView view() const { return {ids, {columns.begin(), columns.end()}}; }
};

//! Keeps a frame as the newest of two, or in the place of the same one of an iteration before; of its columns only
//! those that are wanted.
void remember(std::deque<KeptPoints>& kept, std::int64_t index, std::span<std::int64_t const> ids,
              std::span<std::span<double const> const> values, std::vector<char> const& wanted);
//! The frame of this number; nullptr: it is not kept.
KeptPoints const* kept_frame(std::deque<KeptPoints> const& kept, std::int64_t index);

//! One summand of a mean over frames.
struct FramePart
{
    PointsView points;
    double weight = 1;
};

struct Power
{
    double net = 0;    //!< W: sum over points and components
    double moved = 0;  //!< W: of their magnitudes
};

//! The sum over the points of the first load of (sum of loads) times (sum of motions), found by id. A point that a part
//! lacks takes what the first part that has it says; one whose motion nobody knows has none. Ids in the same order
//! everywhere: one pass without a look-up.
Power power_of(std::size_t load, std::size_t motion, std::size_t width, std::span<FramePart const> loads,
               std::span<FramePart const> motions);

//! The mean of the samples that a solver took of an edge in one window: the very numbers that it was handed.
struct Tally
{
    std::vector<char> columns;  //!< which of them are added up
    int samples = 0;
    std::array<double, 3> weights{};  //!< sums over the samples, of the newest frames
    Held<std::int64_t> ids;
    std::vector<Held<double>> whole;  //!< the only sample so far is a frame as it came; else empty
    std::vector<std::vector<double>> sums;

    void restart();
    //! `values`: the sample; `by`: the weights of the newest frames in it, of which `newest` is the first.
    void add(Frame const& newest, std::vector<std::span<double const>> const& values, std::array<double, 3> const& by);
    //! As a part whose weight makes the sums a mean; samples > 0.
    FramePart mean() const;
};

//! What a sender of loads says beside its frame of a window that is looked at, per pair [W]; not a number: unknown.
struct SaidPower
{
    std::int64_t frame = 0;
    std::uint32_t iteration = 0;
    std::vector<double> of_frame = {};   //!< the frame times the newest motion that came, as it came
    std::vector<double> of_window = {};  //!< what it gives in the window by its own reckoning

    std::vector<double> numbers() const;
    //! Nothing if it is not what numbers() makes for so many pairs.
    static std::optional<SaidPower> from(std::span<double const> numbers, std::size_t pairs);
};

//! The books of energy of one edge of loads, at its receiver. They must close in two ways.
//!
//! To rounding: what came, as it came, times the receiver's motion, is what its solver was handed times that
//! motion; and what the sender says that its frame gives is what the receiver finds. Loads that reach other points
//! than they were made for have the right sum and the wrong power.
//!
//! To a physical tolerance: the work that the sender reckons to have given, by the motion that it was told, is what
//! the receiver got: mean of the samples times the mean of its old and new velocity. The difference is made by
//! staggering (Piperno, Farhat, Comput. Methods Appl. Mech. Engrg. 190 (2001) 3147); see schedule/README.md.
class WorkAccount
{
 public:
    explicit WorkAccount(std::string name) : name_(std::move(name)) {}

    //! Two figures of one power [W] that differ by rounding only; `moved`: the magnitudes in it.
    //! `first` and `second`: what they are, e.g. "came" and "taken".
    void same(std::int64_t window, char const* first, double expected, char const* second, double found, double moved);
    //! Both of one window, in any order [W]; the window's length [s] with the receiver's.
    //! Per pair, NaN where one side does not know it: then the pair is left out.
    void given(std::int64_t window, std::vector<double> power);
    void taken(std::int64_t window, std::vector<Power> power, double length);

    //! What does not close to rounding, relative to what moved; empty: everything does.
    std::string violation(double rounding) const;
    //! Staggering makes or takes more than this part of the work moved; empty: it does not, or there were not yet
    //! enough windows to tell.
    std::string excess(double tolerance) const;
    nlohmann::ordered_json summary() const;

 private:
    struct Half
    {
        std::optional<std::vector<double>> given;
        std::optional<std::vector<Power>> taken;
        double length = 0;
    };
    void settle(std::int64_t window);

    std::string name_;
    std::map<std::int64_t, Half> halves_;  //!< windows of which one side is known
    std::int64_t looks_ = 0;
    double given_ = 0, taken_ = 0, moved_ = 0;  //!< J
    double worst_ = 0;                          //!< largest relative difference of same()
    std::string worst_text_;
};

//! How one edge's energy is reckoned, at either end.
struct Work
{
    std::vector<PowerPair> pairs;
    int motion;                               //!< the edge back, as the scene counts
    int lag;                                  //!< of the edge back
    bool whole_window;                        //!< a frame stands for its window (sample: hold), not for its end
    std::optional<WorkAccount> account = {};  //!< receiver
};

}  // namespace sluice
