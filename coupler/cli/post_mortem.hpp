#pragma once

#include <optional>
#include <string>

#include "coupler/cli/crew.hpp"

namespace sluice {

//! The exit code of a run that ended early, and the message: its first line names who was the root cause, why, in which
//! window and at which time; who stopped because of that is folded into one line.
struct Verdict
{
    int exit = 0;
    std::string message;
};

//! Which member failed by itself, not because another one did; nothing: none said so.
std::optional<std::size_t> root_cause(Crew& crew);
Verdict explain(Crew& crew, std::optional<std::size_t> root);

//! "in window 12 of 500 (t = 0.34 s)"
std::string place_of(MappedStatus const& page);
//! `"left" in window 3 of 10 (t = ...), "right" before its first window`
std::string places_of(Crew const& crew);

//! How a job ended; of one that mpirun started, what mpirun says in its log, if anything.
std::optional<Ending> ending_of(Job& job);

}  // namespace sluice
