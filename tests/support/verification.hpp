#pragma once

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>

//! Verification results: printed by the test (`case  metric  value  reference  error  mark  seconds`) and appended as
//! one JSON object a line to the file named by SLUICE_VERIFY_JSONL, from which `./dev verify --json` makes its list.
namespace verification {

//! Seconds since construction, to state an error beside its run time.
class Stopwatch
{
 public:
    double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }

 private:
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

//! One metric of one case: passes when `error <= mark`. Returns whether it does: CHECK(report({...})).
struct Result
{
    std::string id;      //!< the case as in the catalogue: "L01", "D03"
    std::string metric;  //!< what is measured, with its parameters: "k/d2 at f=0.85 [-]"
    double value;
    double reference;
    double error;  //!< in the norm of the case
    double mark;   //!< the largest error that passes; its source is named beside the call
    double seconds;
};

inline bool report(Result const& r)
{
    bool const pass = r.error <= r.mark;  // false for NaN
    std::printf("%-5s %-52s value %-14.8g reference %-14.8g error %-11.3e mark %-9.2e %s  %.2f s\n", r.id.c_str(),
                r.metric.c_str(), r.value, r.reference, r.error, r.mark, pass ? "pass" : "FAIL", r.seconds);
    std::fflush(stdout);
    if (char const* file = std::getenv("SLUICE_VERIFY_JSONL")) {
        auto number = [](double x) {
            char text[64];
            std::snprintf(text, sizeof text, "%.17g", x);
            return x == x && x - x == 0 ? std::string(text) : std::string("null");
        };
        std::ofstream(file, std::ios::app)
            << R"({"case":")" << r.id << R"(","metric":")" << r.metric << R"(","value":)" << number(r.value)
            << R"(,"reference":)" << number(r.reference) << R"(,"error":)" << number(r.error) << R"(,"mark":)"
            << number(r.mark) << R"(,"pass":)" << (pass ? "true" : "false") << R"(,"seconds":)" << number(r.seconds)
            << "}\n";
    }
    return pass;
}

}  // namespace verification
