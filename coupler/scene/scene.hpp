#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "coupler/base/data.hpp"
#include "coupler/scene/reader.hpp"

namespace sluice {

//! How a receiver sees an edge inside a window, at its own sub-step times.
enum class Sampling
{
    hold,   //!< the value of the window's end, all through the window
    linear  //!< a straight line from the window's begin to its end
};

//! An axis-parallel box; the third coordinate is not looked at in 2D. Points on its faces are inside.
struct Box
{
    std::array<double, 3> min{}, max{};  //!< m
    bool is_empty() const { return min[0] > max[0]; }
    bool operator==(Box const&) const = default;
};

//! Data that flows from one participant to another, once a window.
struct Edge
{
    int from = 0;  //!< index into Scene::participants
    int to = 0;
    int data = 0;     //!< index into Scene::data
    int lag = 0;      //!< 0: the receiver waits for this window's result; 1: it uses the last one's
    int predict = 0;  //!< order of the extrapolation over the lag: 0, 1 or 2
    Sampling sample = Sampling::linear;
    std::optional<Box> region;  //!< only points inside travel
    Problem place;              //!< where its `data` stands in the scene
    std::string path;           //!< "couplings[0].data"
};

struct ParticipantSpec
{
    std::string name;
    std::string solver;                //!< an executable beside `sluice` or on PATH; empty if `command` is given
    std::vector<std::string> command;  //!< program and arguments; the scene and `--as NAME` are appended
    std::string host;                  //!< address where it listens; empty: this host
    int ranks = 1;                     //!< processes it consists of
    Problem place;                     //!< where its solver or command stands in the scene
};

//! Participants that repeat each window until what they exchange converges.
struct ImplicitGroup
{
    enum class Method
    {
        constant,  //!< constant under-relaxation
        aitken,    //!< dynamic under-relaxation
        iqn_ils    //!< interface quasi-Newton, inverse from least squares
    };
    bool has(int participant) const
    {
        return std::find(participants.begin(), participants.end(), participant) != participants.end();
    }

    std::vector<int> participants;  //!< indices into Scene::participants
    Method method = Method::iqn_ils;
    double relaxation = 0.5;  //!< of the first iteration, or of all (constant)
    int history = 8;          //!< windows whose differences IQN-ILS reuses
    int max_iterations = 50;
    double tolerance = 1e-6;                   //!< relative: |x_new - x_old| <= tolerance |x_new|, 2-norm over a column
    std::map<std::string, double> tolerances;  //!< "data" or "data.column" with a tolerance of its own
};

struct CheckpointPlan
{
    double interval = 600;     //!< s of wall time between two; 0: none by time
    std::int64_t windows = 0;  //!< every so many windows; 0: none by count
    int keep = 2;              //!< generations
};

enum class OnViolation
{
    warn,
    stop,
    off
};

enum class TransportKind
{
    automatic,  //!< mpi under mpirun, zmq where a participant has a host or an address is given, else shm
    shm,
    zmq,
    mpi
};

//! A frame of reference that turns, as a centrifuge does. What is at rest in it stays where it is in the scene.
struct Rotation
{
    std::array<double, 3> point{};             //!< on the axis [m]; the third is 0 in 2D
    std::array<double, 3> direction{0, 0, 1};  //!< of the axis, unit vector; out of the plane in 2D
    double rate = 0;                           //!< angular velocity about it once it is reached [rad/s]
    double ramp = 0;                           //!< time in which it is reached, from 0 at t = 0, evenly [s]
    bool centrifugal = true, coriolis = true, euler = true;  //!< which of the accelerations act
};

//! A validated scene: everything but the solvers' own `config` blocks. SI units. Constant once loaded.
struct Scene
{
    std::filesystem::path file;
    std::string text;  //!< the file as read
    std::string title;
    int dimension = 2;
    std::array<double, 3> gravity{};   //!< m/s2; the third is 0 in 2D
    std::optional<Rotation> rotation;  //!< of the frame of all data; absent: inertial
    Problem frame_place;               //!< where frame stands
    double end = 0;                    //!< s
    std::optional<double> window;      //!< s; absent: the solvers' own choice ("auto")
    Problem window_place;              //!< where time.window stands in the scene, or time if it does not
    std::vector<ParticipantSpec> participants;
    std::vector<Edge> edges;
    std::vector<DataSpec> data;  //!< the vocabulary and what the scene declares
    int pace = 0;  //!< index of the participant whose word on window lengths, the end and checkpoints counts
    std::vector<ImplicitGroup> implicit;
    CheckpointPlan checkpoint;
    bool restart_on_death = false;   //!< on-death: restart
    double ledger_tolerance = 1e-9;  //!< relative
    OnViolation on_violation = OnViolation::warn;
    std::int64_t energy_every = 199;  //!< windows between two in which work is reckoned; 0: never
    double energy_tolerance = 0.1;    //!< staggering may make this part of the work moved
    TransportKind transport = TransportKind::automatic;
    std::string address;         //!< tcp://127.0.0.1:PORT, or empty: ipc or shared memory
    int port = 0;                //!< first tcp port, when participants have hosts; else 0
    std::filesystem::path keys;  //!< directory of CURVE keys; empty: none
    bool insecure = false;       //!< security: insecure
    std::vector<std::string>
        remote;                   //!< command that starts a program on another host: followed by HOST and the program
    double output_interval = 0;   //!< s, of pictures and archives; 0: only the first and the last state
    double series_interval = 0;   //!< s, of rows in the time series; 0: the first and the last
    int coarsen = 1;              //!< lattice arrays are written averaged over this many cells each way
    double connect_timeout = 60;  //!< s
    double silence_timeout = 10;  //!< s without a sign of life from a peer's process
    double window_timeout = 0;    //!< s of wall time that one window may take; 0: any
    std::string canonical;        //!< `path = value` lines of all of the above, compared at handshake
    std::uint64_t hash = 0;       //!< XXH3 of `canonical`
    std::vector<std::string> overrides;

    int index_of(std::string_view participant) const;  //!< -1: none of that name
    std::vector<std::string> participant_names() const;
    std::vector<std::string> data_names() const;
};

//! A scene with the readers of its solvers' blocks; mistakes are collected in `diagnostics` and not yet thrown.
struct LoadedScene
{
    Scene scene;
    std::shared_ptr<Diagnostics> diagnostics;
    std::vector<Reader> configs;  //!< one per participant, outermost: `finish()` throws everything found so far
};

//! What must be equal for a run to go on from another one's checkpoint: all that the scene says but when the run ends,
//! when checkpoints are taken, how long is waited and what happens when a participant dies.
std::uint64_t physics_hash(Scene const& scene);

//! Letters, digits, _ and -, at most 64: what may name a participant, and so its files.
bool is_identifier(std::string const& name);

//! Reads and checks a scene. Throws only when the text is not YAML.
LoadedScene load_scene(std::filesystem::path const& file, std::vector<std::string> const& overrides);

//! The same for a text; `keys` gets what was asked for.
LoadedScene load_scene_text(std::string const& text, std::filesystem::path const& file,
                            std::vector<std::string> const& overrides = {}, std::vector<Key>* keys = nullptr);

//! Names that no participant may have: a run's directory has files of these names for itself.
std::vector<std::string_view> const& reserved_names();

//! The names along one circle of lag-0 edges, first name repeated at the end; empty if there is none.
std::vector<std::string> lag0_circle(Scene const& scene);

}  // namespace sluice
