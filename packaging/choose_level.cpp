#ifdef __clang__
using _Bool = bool;  // the next header is C; GCC's C++ knows the word
#endif
#include <sys/platform/x86.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "packaging/level.hpp"

namespace {

//! What the processor has and the operating system saves. Each level contains those below it (AMD64 ABI, sec. 3.1.1);
//! no processor has AVX2 without SSE4.2 and its like, which are therefore not asked for.
bool has_v3()
{
    return CPU_FEATURE_ACTIVE(AVX2) && CPU_FEATURE_ACTIVE(FMA) && CPU_FEATURE_ACTIVE(BMI1) &&
           CPU_FEATURE_ACTIVE(BMI2) && CPU_FEATURE_ACTIVE(F16C) && CPU_FEATURE_ACTIVE(LZCNT) &&
           CPU_FEATURE_ACTIVE(MOVBE);
}

bool has_v4()
{
    return has_v3() && CPU_FEATURE_ACTIVE(AVX512F) && CPU_FEATURE_ACTIVE(AVX512BW) && CPU_FEATURE_ACTIVE(AVX512CD) &&
           CPU_FEATURE_ACTIVE(AVX512DQ) && CPU_FEATURE_ACTIVE(AVX512VL);
}

}  // namespace

//! bin/NAME of a portable build: becomes ../lib/sluice/LEVEL/NAME, the solver compiled for what this processor has.
//! By exec: process, arguments (argv[0] too), environment, signals and the parent-death signal stay what they were.
//! SLUICE_ISA=LEVEL takes another level. Exit codes of its own: 2 for a level that is not here, 7 for a missing file.
int main(int, char** argv)
{
    level::Level const levels[] = {{"x86-64", true}, {"x86-64-v3", has_v3()}, {"x86-64-v4", has_v4()}};
    char const* const wanted = std::getenv("SLUICE_ISA");
    auto const choice = level::choose(levels, wanted ? wanted : "");
    if (!choice.name) {
        std::fprintf(stderr, "%s\n", choice.why_not.c_str());
        return 2;
    }
    std::error_code error;
    auto const self = std::filesystem::read_symlink("/proc/self/exe", error);
    auto const solver = self.parent_path().parent_path() / "lib/sluice" / *choice.name / self.filename();
    ::execv(solver.c_str(), argv);
    std::fprintf(stderr, "%s: %s (needed: the solver for this processor). Install Sluice again.\n", solver.c_str(),
                 std::strerror(errno));
    return 7;
}
