#include "tests/support/fault_row.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <exception>

#include "tests/support/verification.hpp"

namespace sluice::test {
namespace {

std::atomic<int> failures{0};

//! Listens to every assertion of this executable.
struct FailureCounter final : doctest::IReporter
{
    explicit FailureCounter(doctest::ContextOptions const&) {}
    void report_query(doctest::QueryData const&) override {}
    void test_run_start() override {}
    void test_run_end(doctest::TestRunStats const&) override {}
    void test_case_start(doctest::TestCaseData const&) override {}
    void test_case_reenter(doctest::TestCaseData const&) override {}
    void test_case_end(doctest::CurrentTestCaseStats const&) override {}
    void test_case_exception(doctest::TestCaseException const&) override { ++failures; }
    void subcase_start(doctest::SubcaseSignature const&) override {}
    void subcase_end() override {}
    void log_assert(doctest::AssertData const& assertion) override { failures += assertion.m_failed; }
    void log_message(doctest::MessageData const& message) override
    {
        failures += message.m_severity != doctest::assertType::is_warn;  // FAIL
    }
    void test_case_skipped(doctest::TestCaseData const&) override {}
};

int number_of(Row::Repeats repeats)
{
    char const* const text = std::getenv("SLUICE_REPEATS");
    if (!text) return repeats.brief;
    if (std::string(text) == "all") return repeats.stated;
    return std::min(repeats.stated, repeats.brief * std::max(1, std::atoi(text)));
}

bool for_verify()
{
    return std::getenv("SLUICE_VERIFY_JSONL") != nullptr;
}

}  // namespace

Row::Row(std::string id, std::string what, Repeats repeats)
    : id_(std::move(id)), what_(std::move(what)), total_(number_of(repeats))
{}

void Row::close_repeat()
{
    if (round_ >= 0) broken_ += failures != failures_before_;
    failures_before_ = failures;
}

bool Row::next()
{
    close_repeat();
    return ++round_ < total_;
}

void Row::skip(std::string const& why)
{
    skipped_ = true;
    MESSAGE(id_ << ": " << what_ << ": skipped: " << why);
}

void Row::took(double seconds, double limit)
{
    slowest_ = std::max(slowest_, seconds);
    limit_ = limit;
    CHECK(seconds < limit + hang);
}

Row::~Row()
{
    if (skipped_) return;
    bool const broken_off = round_ < total_;  // a REQUIRE, or an exception
    if (broken_off) ++broken_;
    double const seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    int const done = broken_off ? round_ + 1 : total_;
    if (!for_verify()) {
        MESSAGE(id_ << ": " << what_ << ": " << done << " repeats, " << broken_ << " break a rule"
                    << (limit_ > 0 ? ", slowest " + std::to_string(slowest_) + " s" : ""));
        return;
    }
    auto line = [&](std::string const& metric, double value, double reference, double error, double mark) {
        CHECK(verification::report({.id = id_,
                                    .metric = what_ + ": " + metric,
                                    .value = value,
                                    .reference = reference,
                                    .error = error,
                                    .mark = mark,
                                    .seconds = seconds}));
    };
    line("repeats of " + std::to_string(done) + " that break a rule [-]", broken_, 0, broken_, 0);
    if (limit_ > 0) line("slowest [s]", slowest_, limit_, slowest_, limit_);
}

}  // namespace sluice::test

DOCTEST_REGISTER_LISTENER("failures", 1, sluice::test::FailureCounter);
