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
         "`dmesg`) or left its loop over the windows: the message shows the last lines of its log, RUN/NAME.log. Or\n"
         "it gave no sign of life for timeouts.silence: look whether its process is stopped (state T) or its host\n"
         "cannot be reached. A solver that computes for long is alive: a thread of its own answers for it."},
        {4, "timeout", "a partner never came, or a window never ended",
         "A participant did not come within timeouts.connect: look whether it was started, and whether it is still\n"
         "preparing. Or a window took longer than timeouts.window; the message says who computes and who waits."},
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
        {-1, "key", "... is not a key (keys: ...)",
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
         "Changes the scene for one run: keys joined by dots, list items by index: couplings.1.lag=1. A mistake in\n"
         "such a value is shown as `--set` instead of a line."},
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
        {-1, "lost", "participant ... is lost: ...; no heartbeat for ...",
         "Its process ended, was stopped, or cannot be reached any more. What it said last stands in RUN/NAME.log; if\n"
         "it stopped because of another participant, the first line that `sluice run` prints names that one."},
        {-1, "absent", "... did not come within ...; waiting for ...",
         "Everybody waits until all participants have met. The message has the commands that start the missing ones;\n"
         "in brackets stands what is known about why. timeouts.connect (s) is how long they wait."},
        {-1, "scenes", "participants ... have different scenes: ...",
         "They were given different files, or different --set. The first line that differs is shown as both have it."},
        {-1, "stuck", "... takes nothing in: no room to send ...",
         "The receiver has not read for so long that the queue between the two is full. Look where it hangs."},
        {-1, "finite", "... is not finite in frame ...",
         "A solver sent NaN or infinity, and was stopped before anybody got it. The field, the point and the frame are\n"
         "named; look for the cause in the solver that is named first."},
        {-1, "ledger", "ledger, in ...; ledger, first in ...; ... does not close: ...",
         "What came over an edge (force, torque, volume) is not what the solver took, or what it wrote is not what was\n"
         "sent. Often a solver that does not read an edge in every window. ledger: {on-violation: stop} ends the run."},
        {-1, "written", "... wrote nothing to ... before ...; ... wrote ... twice in ...",
         "A participant writes each of its edges once before the first window and once in every window."},
        {-1, "early", "... left its loop over the windows before their end ...; ... left its run early; ...",
         "A solver has to go through all windows. One that may end the run sooner says so: Participant::end_run()."},
        {-1, "frame", "frame ... is missing in ...; a plan for window ... was due: ...; ... of another run",
         "A message was lost, doubled, or is from another run. Look for processes that an earlier run left, and end\n"
         "them."},
        {-1, "checkpoint", "no complete checkpoint to go on from; ... its checkpoint is of another scene",
         "A checkpoint is complete once all participants have written theirs, and goes with its scene: only time.end,\n"
         "checkpoint, timeouts and on-death may be others when a run is resumed."},
        {-1, "state", "... cannot be resumed: its solver does not keep its state; ... does not keep its state",
         "The solver does not save and restore its state (Participant::keeps()), which checkpoints, implicit groups and\n"
         "on-death: restart need."},
        {-1, "apart", "... goes on from window ..., ... from window ...; its config is not that of its checkpoint",
         "Participants that are started by hand must all be started with --resume, or none, and with the config that\n"
         "the checkpoint was taken with."},
        {-1, "converge", "window ... did not converge in ... iterations",
         "An implicit group gave up after max_iterations and went on with what it had. Shorter windows, a looser\n"
         "tolerance, iqn-ils instead of relaxation, or more iterations."},
        {-1, "sockets", "not a directory that only this user can enter",
         "Sockets of a run lie in a directory of mode 0700 under XDG_RUNTIME_DIR or /tmp. It belongs to somebody else,\n"
         "or others may enter it: remove it, or set XDG_RUNTIME_DIR."},
        {-1, "space", "Free some space",
         "The disk is full, or a limit of this user is reached. What was written before is whole; make room and\n"
         "resume."},
    };
    return all;
}

}  // namespace sluice
