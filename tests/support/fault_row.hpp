#pragma once

#include <chrono>
#include <string>

namespace sluice::test {

//! One row of the fault matrix (tests/faults/README.md): counts its repeats and those in which an assertion failed. In
//! a long run it writes a line for `./dev verify`. Link tests/support/fault_row.cpp.
//!     Row row("F1", "kill -9 at a random moment", {.brief = 5, .stated = 200});
//!     while (row.next()) { ... CHECK(...); row.took(seconds, limit); }
class Row
{
 public:
    //! SLUICE_REPEATS not set: `brief` repeats; "all": the `stated` ones; a number: that times `brief`, at most
    //! `stated`.
    struct Repeats
    {
        int brief, stated;
    };
    Row(std::string id, std::string what, Repeats repeats);
    Row(Row const&) = delete;
    Row& operator=(Row const&) = delete;
    ~Row();

    bool next();                            //!< begins a repeat; false: all are done
    int round() const { return round_; }    //!< from 0
    int repeats() const { return total_; }  //!< how many there will be
    void skip(std::string const& why);      //!< this machine cannot: said, and no line is written
    //! From the fault to the end of it all [s], and the most that the matrix allows. Asserted in long runs only, where
    //! nothing else is to be going on; a test on a busy machine only bounds it by `hang`.
    void took(double seconds, double limit);
    static constexpr double hang = 20;  //!< s

 private:
    void close_repeat();
    std::string id_, what_;
    int total_, round_ = -1, broken_ = 0, failures_before_ = 0;
    bool skipped_ = false;
    double slowest_ = 0, limit_ = 0;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace sluice::test
