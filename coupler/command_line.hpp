#pragma once

#include "coupler/coupler.hpp"

//! How a process becomes a participant and ends as one: what run() and the C interface have in common.
namespace sluice {

//! What the command line says. Returns -1, or the exit code of a process that is done: 0 after --help or --version,
//! 2 after a mistake that has been printed.
int parse_command_line(int argc, char const* const* argv, JoinOptions& options);

//! SIGTERM ends the run at the next window, with a checkpoint if it can; a second one ends the process. A broken pipe
//! is an error, not a signal. A process that `sluice run` started ends with it.
void heed_signals();

//! Every line of standard output reaches the log at once: whoever reads it after a crash finds the last ones.
void write_log_by_lines();

//! Throws Error (exit 7) if lines of standard output were lost, where it is a file: the disk is full or broken.
void require_log();

//! What a process ends with whose run ended with `exit`: mpirun ends the others when one ends with another code than 0;
//! there the launcher reads the run's code on the status page.
int exit_for_launcher(int exit);

}  // namespace sluice
