#include "coupler/cli/explain.hpp"

namespace sluice {

std::vector<Explanation> const& explanations()
{
    static std::vector<Explanation> const all = {
        {0, "ok", "done", "The run reached time.end, or the command did what was asked."},
        {2, "config", "usage, or a scene with errors",
         "The command line or the scene cannot be accepted; nothing was started. Every mistake is listed as\n"
         "file:line:column: path = what was seen (what is needed). `sluice check SCENE` repeats the list."},
        {3, "died", "a participant ended before the run did",
         "A solver crashed, was killed (signal 9 without a reason: look for the kernel's out-of-memory killer in\n"
         "`dmesg`) or left its loop over the windows. The message shows the last lines of its log, RUN/NAME.log."},
        {4, "timeout", "a partner is silent, or never came",
         "A participant did not come within timeouts.connect, or its process gave no sign of life for\n"
         "timeouts.silence. A solver that computes for long is alive: a thread of its own answers for it. Look\n"
         "whether its process is stopped (state T), its host is unreachable, or it is still preparing."},
        {5, "protocol", "versions, scenes or frames of two participants do not match",
         "Two participants were started with different scenes, another --set, or another version; the message shows\n"
         "the first line that differs. A directory that another run uses is refused with this code, too."},
        {6, "numerical", "a number that is not finite, or a run that blew up",
         "A solver found NaN, infinity or an escaped particle. Take shorter windows or steps, a lower lattice\n"
         "velocity, softer contacts; the message names the step and the first particle or cell."},
        {7, "io", "files, disk, or a missing package",
         "A file cannot be read or written, the disk is full, or a program (mpirun, graphviz, Python packages) is\n"
         "missing. `sluice doctor` lists what is there."},
        {8, "security", "refused for safety",
         "A partner did not prove who it is, or a connection would have left this host without keys. Make keys with\n"
         "`sluice keygen` and name their directory in security: {keys: DIR} of the scene, the same on all hosts."},
        {70, "internal", "a bug of ours", "This must not happen. Keep the scene and RUN/*.log, and report it."},
        {75, "stopped", "stopped with a checkpoint: can be resumed",
         "The run was asked to stop and wrote a checkpoint first. `sluice resume RUN` goes on from there."},
        {130, "interrupted", "interrupted", "SIGINT (Ctrl-C) or SIGTERM ended the run. Results up to then are kept."},
        {-1, "key", "... is not a key (keys: ...). Did you mean ...?",
         "The scene has a key that nobody reads: misspelt, or in the wrong mapping. The list shows what goes there;\n"
         "`sluice schema` has all keys with their meaning."},
        {-1, "missing", "... is missing (...)",
         "A key that must be there is not. The place shown is that of the mapping that it belongs into."},
        {-1, "twice", "... is given twice (first in line ...)",
         "YAML parsers keep one of two equal keys in silence. Sluice does not guess which one is meant."},
        {-1, "number", "... is not a number (...)",
         "A plain decimal number is needed: 0.1, 1e-3, -5. No units, no quotes, no octal or hexadecimal, no .nan\n"
         "and no .inf. Everything is in SI units."},
        {-1, "circle", "the lag-0 edges form a circle",
         "With lag: 0 a receiver waits for the sender's result of the same window. In a circle everybody waits for\n"
         "ever. Give one edge of it lag: 1: its receiver then uses the last window's result, continued by predict."},
        {-1, "deadlock", "deadlock: ... waits for ...",
         "`sluice check` plays the windows through without solvers and found that nobody can go on; the list names\n"
         "who waits for which frame of whom. It comes from a circle of edges with lag: 0."},
        {-1, "lag", "lag, predict, sample",
         "lag: 0 delivers this window's result, lag: 1 the last window's. predict: none | linear | quadratic "
         "continues\n"
         "the last results over the lag. sample: linear | hold says what a receiver sees inside a window."},
        {-1, "window", "... is longer than the whole run; the last window ends later than time.end",
         "All participants exchange at the ends of windows of one length. time.window: auto takes the longest one "
         "that\n"
         "every solver can do. A run has ceil(end / window) windows, so it may end after time.end."},
        {-1, "unit", "... is not a unit; ... is not an SI base or derived unit",
         "Units of data of your own are products of SI units with powers: m/s, kg/m3, N m, W/m2/K, 1. Nothing is\n"
         "converted: both ends of a coupling must mean the same. Units with a prefix (mm, kPa) are accepted with a\n"
         "warning."},
        {-1, "participant", "there is no such participant",
         "from, to, time.pace and implicit groups name participants of the scene by their key under participants."},
        {-1, "executable", "no such executable",
         "A solver is looked for beside `sluice`, then on PATH. Build it, add its directory to PATH, or give\n"
         "command: [program, arguments] with a path."},
        {-1, "set", "--set path=value",
         "Changes the scene for one run: keys joined by dots, list items by index: couplings.1.lag=1. All but the "
         "last\n"
         "key must be in the scene. A mistake in such a value is shown as `--set` instead of a line."},
        {-1, "unused", "nobody reads ...; ... reads nobody",
         "A warning: a participant without any coupling to or from it runs beside the others. Often a coupling is\n"
         "missing, or commented out."},
        {-1, "hosts", "the run cannot be started on other hosts",
         "Before anything is started, every other host is asked through the words of `remote` whether the current\n"
         "directory, the scene, the program and the directory of the run are there under the same paths. The words\n"
         "must reach the host without a password: try them with `true` behind. On hosts that share no files start the\n"
         "participants by hand, each with an --out of its host."},
        {-1, "running", "another run is going on there",
         "A directory belongs to one run at a time. Wait for it, end it, or use another --out."},
        {-1, "packages", "no report: ... (needed: ...)",
         "The report is made by Python with numpy, h5py and matplotlib of the distribution: install the packages that\n"
         "`sluice doctor` names, then `sluice report RUN`. The results are complete without it."},
    };
    return all;
}

}  // namespace sluice
