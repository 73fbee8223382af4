#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "coupler/base/error.hpp"
#include "coupler/base/state.hpp"
#include "coupler/scene/scene.hpp"
#include "coupler/transport/transport.hpp"

//! The public face of Sluice: all that a solver needs to take part in a coupled run.
//!
//!     void solve(sluice::Participant& self)
//!     {
//!         auto config = read_config(self.config());           // throws every mistake at once
//!         self.propose_window(config.step);
//!         self.write<Load>("grains", initial);                 // every out-edge starts with a state
//!         for (sluice::Window const& window : self.windows()) {
//!             auto grains = self.read<Kinematics>("grains", window);
//!             ... advance from window.begin to window.end, sampling grains.at(time) ...
//!             self.write<Load>("grains", load);
//!         }
//!     }
//!     int main(int argc, char** argv) { return sluice::run(argc, argv, solve); }
namespace sluice {

struct Window
{
    std::int64_t index = 0;
    double begin = 0;     //!< s
    double end = 0;       //!< s
    double length = 0;    //!< s
    bool output = false;  //!< the state at its end is to be recorded
    bool series = false;  //!< a row of the time series is to be written at its end
    bool last = false;    //!< the run ends with it
    int iteration = 0;    //!< in an implicit group: how often it has been computed before

    //! Whether something done every `interval` seconds is due at its end: the first one at or after each multiple; 0
    //! and the last window: at the end of the run.
    bool due(double interval) const;
    //! How many equal steps of at most `longest` seconds fill the window.
    std::int64_t steps(double longest) const;
    //! The k-th of `steps` times that divide the window evenly, begin and end exactly.
    double time(std::int64_t k, std::int64_t steps) const
    {
        return k == 0       ? begin
               : k == steps ? end
                            : begin + length * (static_cast<double>(k) / static_cast<double>(steps));
    }
};

//! dem -> lbm: where the grains are and how they move. 2D: position and velocity have 2 numbers a point, interleaved.
struct Kinematics
{
    static constexpr std::string_view name = "kinematics";
    std::span<std::int64_t const> id;
    std::span<double const> position;          //!< m
    std::span<double const> velocity;          //!< m/s
    std::span<double const> angular_velocity;  //!< rad/s, 1 number a point in 2D
    std::span<double const> radius;            //!< m

    std::vector<std::span<double const>> columns() const { return {position, velocity, angular_velocity, radius}; }
    static Kinematics from(std::span<std::int64_t const> id, std::vector<std::span<double const>> const& c)
    {
        return {id, c[0], c[1], c[2], c[3]};
    }
};

//! lbm -> dem: force and torque on each grain. In 2D per metre of thickness.
struct Load
{
    static constexpr std::string_view name = "load";
    std::span<std::int64_t const> id;
    std::span<double const> force;   //!< N
    std::span<double const> torque;  //!< N m

    std::vector<std::span<double const>> columns() const { return {force, torque}; }
    static Load from(std::span<std::int64_t const> id, std::vector<std::span<double const>> const& c)
    {
        return {id, c[0], c[1]};
    }
};

//! mpm -> lbm, dem -> lbm: solids that are finer than the fluid's cells.
struct SolidPhase
{
    static constexpr std::string_view name = "phase";
    std::span<std::int64_t const> id;
    std::span<double const> position;      //!< m
    std::span<double const> velocity;      //!< m/s
    std::span<double const> solid_volume;  //!< m3, in 2D m2

    std::vector<std::span<double const>> columns() const { return {position, velocity, solid_volume}; }
    static SolidPhase from(std::span<std::int64_t const> id, std::vector<std::span<double const>> const& c)
    {
        return {id, c[0], c[1], c[2]};
    }
};

//! lbm -> mpm, lbm -> dem: what the fluid does to them. In 2D per metre of thickness.
struct BodyForce
{
    static constexpr std::string_view name = "body_force";
    std::span<std::int64_t const> id;
    std::span<double const> force;  //!< N

    std::vector<std::span<double const>> columns() const { return {force}; }
    static BodyForce from(std::span<std::int64_t const> id, std::vector<std::span<double const>> const& c)
    {
        return {id, c[0]};
    }
};

//! What a coupling edge says inside one window. Valid until the next window.
class Samples
{
 public:
    struct Source;
    Samples(Source& source, Window const& window) : source_(&source), begin_(window.begin), end_(window.end) {}
    std::span<std::int64_t const> ids() const;
    //! All columns at a time of the window [s], by the edge's lag, prediction and sampling. Overwritten by the next
    //! call.
    std::vector<std::span<double const>> const& columns(double time);
    //! Whether they may differ within the window. If not, one sample stands for all.
    bool vary() const;

 private:
    Source* source_;
    double begin_, end_;
};

template <class Data>
class Sampled
{
 public:
    explicit Sampled(Samples samples) : samples_(samples) {}
    std::span<std::int64_t const> ids() const { return samples_.ids(); }
    Data at(double time) { return Data::from(samples_.ids(), samples_.columns(time)); }
    bool vary() const { return samples_.vary(); }

 private:
    Samples samples_;
};

//! How a participant is started; what the command line says.
struct JoinOptions
{
    std::filesystem::path scene;
    std::string name;                               //!< which participant of the scene this is
    std::filesystem::path directory;                //!< of the run: results, logs, status
    std::vector<std::string> overrides = {};        //!< path=value
    bool check = false;                             //!< read and check the configuration, then stop
    int rank = 0;                                   //!< which of the participant's processes
    bool resume = false;                            //!< go on from the newest complete checkpoint in `directory`
    std::unique_ptr<Transport> transport = {};      //!< for tests; empty: as the scene says
    std::shared_ptr<LoadedScene const> given = {};  //!< for tests: the scene, read before; then no file is touched
};

class Windows;

class Participant
{
 public:
    explicit Participant(JoinOptions options);
    Participant(Participant&&) noexcept;
    ~Participant();

    Scene const& scene() const;
    std::string const& name() const;
    std::filesystem::path const& directory() const;
    Reader config();        //!< this participant's own block; its finish() throws every mistake of the scene at once
    bool checking() const;  //!< only the configuration is wanted: return after reading it

    //! What this solver can send and take. An edge that says otherwise is a mistake of the scene.
    void sends(std::vector<std::string> const& data);
    void takes(std::vector<std::string> const& data);
    //! The rotation of the frame of reference, or null: it is inertial. Before the configuration is finished: a scene
    //! that rotates is refused for a solver that does not ask, since it would take it for one that does not.
    Rotation const* rotation();
    //! For `window: auto`. Exact: the solver's own step, every window must have this length; else an upper bound.
    void propose_window(double seconds, bool exact = false);

    //! Of the columns of `data` this solver reads only these: others are not sent to it, their spans are empty.
    void reads(std::string_view data, std::vector<std::string> const& columns);
    //! The part of space that this process covers: points with a position outside are not sent to it. An empty box (min
    //! above max in x): other processes of this participant have all points, none are sent here, not even of data
    //! without positions. Before windows().
    void covers(Box const& box);
    //! How this solver keeps and restores all it needs to go on bit for bit: for checkpoints, and for implicit groups,
    //! which repeat windows. `save` fills an empty State. Before windows(), which restores a run that is resumed.
    void keeps(std::function<void(State&)> save, std::function<void(State const&)> restore);

    //! Before windows(): whether this run goes on from a checkpoint. windows() then restores the state; results up to
    //! resumed_at() stay, and the initial state is not to be recorded again.
    bool resumes() const;
    double resumed_at() const;  //!< s; after windows() was called
    //! At the begin of a window: whether, since the last call, this run has gone back to resumed_at(), in place,
    //! because a peer died (on-death: restart). What was recorded after that is then to be dropped.
    bool went_back();

    //! The length of the windows after this one [s], rounded down to what all steps allow. Only for the participant
    //! that paces the run (time.pace): throws Error (exit 2) in others.
    void next_window(double seconds);
    //! The next window is the last one. Only for the participant that paces the run.
    void end_run(std::string const& why);
    //! A checkpoint before one of the next windows; by any participant.
    void request_checkpoint();

    int rank() const;   //!< which of this participant's processes this is
    int ranks() const;  //!< how many they are

    //! The state for every out-edge, before the first window and at the end of each. Sent at once; copied where it must
    //! wait.
    void write(std::string_view to, std::string_view data, std::span<std::int64_t const> ids,
               std::vector<std::span<double const>> const& columns);
    Samples read(std::string_view from, std::string_view data, Window const& window);
    template <class Data>
    void write(std::string_view to, Data const& data)
    {
        write(to, Data::name, data.id, data.columns());
    }
    template <class Data>
    Sampled<Data> read(std::string_view from, Window const& window)
    {
        return Sampled<Data>(read(from, Data::name, window));
    }
    //! The names at the other end of the edges that carry this data; empty when the scene has no such edge.
    std::vector<std::string> receivers(std::string_view data) const;
    std::vector<std::string> senders(std::string_view data) const;
    //! The one of senders(); empty if there is none. Several are an error.
    std::string sender(std::string_view data) const;

    //! Data without points: one number for each component of its columns.
    void write_values(std::string_view to, std::string_view data, std::span<double const> values);
    std::vector<double> read_values(std::string_view from, std::string_view data, Window const& window);

    //! Shakes hands with all participants, then hands out one window after the other, exchanging frames in between.
    Windows windows();
    //! After the last write of a window: whether its result stands. False only in an implicit group, when the window
    //! will be computed again: then nothing is to be recorded. Need not be called outside of such a group.
    bool accepted(Window const& window);

    //! For the report: a figure, a warning, work that was not done and why (share of the whole, 0 to 1).
    void fact(std::string const& name, double value);
    void fact(std::string const& name, std::string const& text);
    void warn(std::string const& text);
    void skipped(std::string const& what, std::string const& why, double share);
    void note(std::string_view text);        //!< one line shown by `sluice run` while this participant prepares itself
    int finish();                            //!< called by run(): the end-of-run handshake, the summary, the exit code
    void fail(Error const& error) noexcept;  //!< called by run(): tells the peers and the status page
    //! Why this process stops, in one line with its name, window, time and process where the error does not say them.
    std::string last_words(Error const& error) const;

    struct Session;

 private:
    std::unique_ptr<Session> session_;
};

//! Range over the windows of a run, for one range-based for loop.
class Windows
{
 public:
    explicit Windows(Participant::Session& session) : session_(&session) {}
    struct End
    {};
    class Iterator
    {
     public:
        explicit Iterator(Participant::Session& session);
        Window const& operator*() const { return window_; }
        Iterator& operator++();
        bool operator==(End) const { return done_; }

     private:
        Participant::Session* session_;
        Window window_;
        bool done_ = false;
    };
    Iterator begin() { return Iterator(*session_); }
    End end() const { return {}; }

 private:
    Participant::Session* session_;
};

//! A whole `main`: command line, scene, solve, exit code. The only place that catches.
int run(int argc, char** argv, std::function<void(Participant&)> const& solve);

}  // namespace sluice
