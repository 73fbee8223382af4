#include "coupler/base/data.hpp"
#include "coupler/cli/schema.hpp"
#include "coupler/scene/scene.hpp"
#include "coupler/scene/units.hpp"

namespace sluice {

using Json = nlohmann::ordered_json;

std::vector<std::pair<std::string, std::string>> const& meanings()
{
    static std::vector<std::pair<std::string, std::string>> const all = {
        {"sluice", "Version of this format."},
        {"title", "Shown in progress, graph and report. Default: the file's name."},
        {"dimension", "2 or 3."},
        {"gravity", "Acceleration of gravity, one number a dimension [m/s2]."},
        {"data", "Data of your own, beside kinematics, load, phase and body_force."},
        {"data.*.meshless", "One point without a place: a number, a signal."},
        {"data.*.columns", "The columns of the data, by name."},
        {"data.*.columns.*.shape", "scalar: 1 number; vector: one a dimension; spin: 1 in 2D, 3 in 3D."},
        {"data.*.columns.*.unit", "A product of SI units with powers: m/s, N m, W/m2/K, 1."},
        {"participants",
         "Who takes part: name (letters, digits, _ and -) and what it is. It listens for those after it."},
        {"participants.*.solver", "An executable beside sluice or on PATH, e.g. dem, lbm, mpm."},
        {"participants.*.command", "Program and arguments instead of solver."},
        {"participants.*.host", "Address or name of the host where it runs; absent: this one."},
        {"participants.*.ranks", "Processes that it consists of."},
        {"participants.*.config", "The solver's own keys: see its README."},
        {"couplings", "What flows from whom to whom, once a window."},
        {"couplings[].from", "The participant that writes."},
        {"couplings[].to", "The participant that reads."},
        {"couplings[].data", "kinematics, load, phase, body_force, or data of your own."},
        {"couplings[].lag", "0: the receiver waits for this window's result; 1: it uses the last window's."},
        {"couplings[].predict", "Continues the last results over the lag."},
        {"couplings[].sample", "What the receiver sees inside a window: the value of its end, or a line to it."},
        {"couplings[].region", "Only points in this box travel."},
        {"couplings[].region.min", "Lowest corner, one number a dimension [m]."},
        {"couplings[].region.max", "Highest corner, one number a dimension [m]."},
        {"time", "How long the run is, and how it is cut into windows."},
        {"time.end", "Simulated time [s]."},
        {"time.window", "Length of a window [s]; auto: the longest that all solvers can do."},
        {"time.pace",
         "The participant whose word on window lengths and the end counts. Default: the first that waits "
         "for nobody in its own window."},
        {"implicit", "Groups of participants that repeat each window until what they exchange converges."},
        {"implicit[].participants", "At least two, with a coupling of lag 1 between them."},
        {"implicit[].method", "constant relaxation, Aitken's, or interface quasi-Newton (least squares)."},
        {"implicit[].relaxation", "Of the first iteration, or of all (constant)."},
        {"implicit[].history", "Windows whose differences iqn-ils reuses."},
        {"implicit[].max_iterations", "Of one window."},
        {"implicit[].tolerance", "Relative change of a column in an iteration; or one each: data, data.column."},
        {"transport", "auto: mpi under mpirun, zmq between hosts, else shared memory."},
        {"address", "ipc, or tcp://127.0.0.1:PORT on this host."},
        {"port", "First tcp port, when participants have hosts."},
        {"security", "Keys for connections between hosts; or insecure on a network that you trust."},
        {"security.keys", "Directory of keys, made by sluice keygen."},
        {"remote", "Command that starts a program on another host: followed by the host and the program."},
        {"frame", "Frame of reference of all data: inertial, or rotating as a centrifuge."},
        {"frame.rotating", "Turns about an axis; gravity is what the scene says, in this frame."},
        {"frame.rotating.axis", "A point on the axis, one number a dimension [m]."},
        {"frame.rotating.direction", "Of the axis; only in 3D. In 2D it points out of the plane."},
        {"frame.rotating.rate", "Angular velocity [rad/s]; 2D: counter-clockwise."},
        {"frame.rotating.ramp", "Time in which the rate is reached, evenly, from t = 0 [s]."},
        {"frame.rotating.centrifugal", "Whether -w x (w x r) acts."},
        {"frame.rotating.coriolis", "Whether -2 w x u acts."},
        {"frame.rotating.euler", "Whether -dw/dt x r acts, while the rate changes."},
        {"checkpoint", "When the state of all participants is written, to go on from."},
        {"checkpoint.interval", "Wall time between two [s]; 0: none by time."},
        {"checkpoint.windows", "Every so many windows; 0: none by count."},
        {"checkpoint.keep", "How many are kept."},
        {"on-death",
         "What happens when a participant dies: stop, or restart it and set the others back to the newest checkpoint."},
        {"ledger", "The account of what is sent and what arrives."},
        {"ledger.tolerance", "Relative difference that is a violation."},
        {"ledger.on-violation", "What happens then."},
        {"ledger.energy", "The account of the work that loads do on moving points."},
        {"ledger.energy.every", "Windows between two that are looked at; 1: each, 0: none."},
        {"ledger.energy.tolerance", "Part of the work moved that staggering may make or take; more is a violation."},
        {"output", "How often results are written."},
        {"output.interval", "Simulated time between pictures and archives [s]; 0: first and last."},
        {"output.series", "Between rows of the time series [s]. Default: as interval."},
        {"output.coarsen", "Lattice arrays are averaged over this many cells each way."},
        {"timeouts", "How long participants wait for each other."},
        {"timeouts.connect", "For everybody to come [s]."},
        {"timeouts.silence", "For a sign of life of a partner's process [s]."},
        {"timeouts.window", "For one window [s], then the run ends; 0: for ever, with a warning after 10 x the usual."},
    };
    return all;
}

namespace {

constexpr char const* octet = "(25[0-5]|2[0-4][0-9]|[01]?[0-9]?[0-9])";

std::string loopback()
{
    return std::string("127\\.") + octet + "\\." + octet + "\\." + octet;
}

//! Lists of numbers have one a dimension.
Json sizes()
{
    auto const lists = [](char const* word, int size) {
        Json const list = {{word, size}};
        Json const box = {{"properties", {{"min", list}, {"max", list}}}};
        Json rotating = {{"axis", list}};
        if (size == 2) rotating["direction"] = false;
        Json const frame = {{"properties", {{"rotating", {{"properties", rotating}}}}}};
        return Json{
            {"properties",
             {{"gravity", list}, {"frame", frame}, {"couplings", {{"items", {{"properties", {{"region", box}}}}}}}}}};
    };
    return {{"if", {{"required", {"dimension"}}, {"properties", {{"dimension", {{"const", 3}}}}}}},
            {"then", lists("minItems", 3)},
            {"else", lists("maxItems", 2)}};
}

//! What goes with hosts, what does not.
Json hosts()
{
    Json const without = {{"not", {{"required", {"host"}}}}};
    return {
        {"if", {{"properties", {{"participants", {{"additionalProperties", without}}}}}}},
        {"then", {{"properties", {{"port", false}, {"security", false}, {"remote", false}}}}},
        {"else",
         {{"required", {"port"}}, {"properties", {{"address", false}, {"transport", {{"enum", {"auto", "zmq"}}}}}}}}};
}

//! Another host: encrypted, or trusted in so many words.
Json secured()
{
    Json const local = {{"properties", {{"host", {{"pattern", "^(localhost|" + loopback() + ")$"}}}}}};
    return {{"if", {{"properties", {{"participants", {{"additionalProperties", local}}}}}}},
            {"then", true},
            {"else", {{"required", {"security"}}}}};
}

Json local_tcp()
{
    return {{"if", {{"required", {"address"}}, {"properties", {{"address", {{"not", {{"const", "ipc"}}}}}}}}},
            {"then", {{"properties", {{"transport", {{"enum", {"auto", "zmq"}}}}}}}}};
}

//! Nothing to restart from, or nothing that survives.
Json restart()
{
    Json const never = {{"required", {"interval"}},
                        {"properties", {{"interval", {{"const", 0}}}, {"windows", {{"const", 0}}}}}};
    return {
        {"if", {{"required", {"on-death"}}, {"properties", {{"on-death", {{"const", "restart"}}}}}}},
        {"then", {{"properties", {{"checkpoint", {{"not", never}}}, {"transport", {{"not", {{"const", "mpi"}}}}}}}}}};
}

}  // namespace

std::vector<std::pair<std::string, Json>> rules()
{
    std::vector<std::string> built_in;
    for (auto const& data : vocabulary()) built_in.push_back(data.name);
    Json const name = {{"pattern", "^[A-Za-z0-9_-]{1,64}$"}, {"not", {{"enum", reserved_names()}}}};
    Json const no_position = {{"propertyNames", {{"not", {{"const", "position"}}}}}};
    Json const meshless = {{"required", {"meshless"}}, {"properties", {{"meshless", {{"const", true}}}}}};
    return {
        {"", {{"allOf", {sizes(), hosts(), secured(), local_tcp(), restart()}}}},
        {"participants", {{"minProperties", 1}, {"maxProperties", 256}, {"propertyNames", name}}},
        {"participants.*", {{"oneOf", {{{"required", {"solver"}}}, {{"required", {"command"}}}}}}},
        {"participants.*.solver", {{"pattern", "^[A-Za-z0-9_-]{1,64}$"}}},
        {"participants.*.host", {{"pattern", "^[A-Za-z0-9._:][A-Za-z0-9._:-]{0,252}$"}}},
        {"data", {{"propertyNames", {{"not", {{"enum", built_in}}}}}}},
        {"data.*", {{"if", meshless}, {"then", {{"properties", {{"columns", no_position}}}}}}},
        {"data.*.columns", {{"minProperties", 1}, {"maxProperties", 30}}},
        {"data.*.columns.*.unit",
         {{"type", {"string", "integer"}}, {"minimum", 1}, {"maximum", 1}, {"pattern", unit_pattern()}}},
        {"couplings[]",
         {{"if", {{"properties", {{"lag", {{"const", 0}}}}}}},
          {"then", {{"properties", {{"predict", {{"const", "none"}}}}}}}}},
        {"address",
         {{"pattern", "^(ipc|tcp://" + loopback() +
                          ":(102[4-9]|10[3-9][0-9]|1[1-9][0-9]{2}|[2-9][0-9]{3}|[1-5][0-9]{4}|6[0-4][0-9]{3}|"
                          "65000))$"}}},
    };
}

}  // namespace sluice
