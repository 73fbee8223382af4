#pragma once

#include <doctest/doctest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <initializer_list>
#include <string>

#include "coupler/base/error.hpp"
#include "tests/support/processor_time.hpp"

namespace verification {

//! Errors against the time that they take. SLUICE_ERRORS names a folder for tables SOLVER.csv (plot_errors.py draws
//! them).
class ErrorTable
{
 public:
    explicit ErrorTable(std::string const& solver)
    {
        if (char const* const folder = std::getenv("SLUICE_ERRORS")) {
            csv_.open(std::string(folder) + '/' + solver + ".csv");
            csv_ << "case,way,cells,error,seconds\n";
        }
    }

    //! `error(cells)` of one way; the finest one is checked, if there is a mark (> 0).
    template <class Error>
    void add(std::string const& what, std::string const& way, std::initializer_list<int> resolutions, double mark,
             Error&& error)
    {
        for (int const cells : resolutions) {
            double const start = unit::processor_time();
            double got = std::nan("");  // blew up
            try {
                got = error(cells);
            } catch (sluice::Error const& e) {
                CHECK(e.exit() == sluice::Exit::numerical);
            }
            double const seconds = unit::processor_time() - start;
            csv_ << what << ",\"" << way << "\"," << cells << ',' << got << ',' << seconds << std::endl;
            std::printf("%-24s %-18s %4d cells: %9.2e in %7.2f s\n", what.c_str(), way.c_str(), cells, got, seconds);
            if (cells == *(resolutions.end() - 1) && mark > 0) {
                CAPTURE(what + ", " + way);
                CHECK(got < mark);
            }
        }
    }

 private:
    std::ofstream csv_;
};

}  // namespace verification
