#include "participants/liggghts/stopped.hpp"

#define OMPI_SKIP_MPICXX  // the deprecated C++ interface does not compile without warnings
#include <error.h>
#include <fix.h>

#include <cstdio>

//! LIGGGHTS' own error functions write to its log and end the process. The loader takes those of the executable before
//! those of a library, so that these stand in their place: they throw, and what they say reaches our user.

namespace liggghts {
namespace {

std::FILE* warnings = nullptr;

[[noreturn]] void stop(std::string text)
{
    throw Stopped{std::move(text)};
}
std::string text_of(char const* text)
{
    return text ? text : "";
}

}  // namespace

void set_warning_file(void* file)
{
    warnings = static_cast<std::FILE*>(file);
}

}  // namespace liggghts

namespace LAMMPS_NS {

void Error::universe_all(char const*, int, char const* text)
{
    liggghts::stop(liggghts::text_of(text));
}
void Error::universe_one(char const*, int, char const* text)
{
    liggghts::stop(liggghts::text_of(text));
}
void Error::all(char const*, int, char const* text)
{
    liggghts::stop(liggghts::text_of(text));
}
void Error::one(char const*, int, char const* text)
{
    liggghts::stop(liggghts::text_of(text));
}
void Error::fix_error(char const*, int, Fix* fix, char const* text)
{
    liggghts::stop("fix " + liggghts::text_of(fix->id) + " (" + liggghts::text_of(fix->style) +
                   "): " + liggghts::text_of(text));
}
void Error::fix_error(char const*, int, Fix* fix, char const* style, char const* text)
{
    liggghts::stop("fix " + liggghts::text_of(fix->id) + " (" + liggghts::text_of(style) +
                   "): " + liggghts::text_of(text));
}
void Error::compute_error(char const*, int, Compute*, char const* text)
{
    liggghts::stop(liggghts::text_of(text));
}
void Error::cg(char const*, int, char const* text)
{
    liggghts::stop(liggghts::text_of(text) + " does not go with coarse graining");
}
void Error::warning(char const*, int, char const* text, int)
{
    std::FILE* const to = liggghts::warnings ? liggghts::warnings : logfile;
    if (to) std::fprintf(to, "WARNING: %s\n", text);
}
void Error::done()
{
    liggghts::stop("the script ends the program (quit)");
}

}  // namespace LAMMPS_NS
