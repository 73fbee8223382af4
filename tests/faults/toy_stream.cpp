// One sends, one takes, nothing comes back: so the sender may run ahead. Keys: points (sent); nap [s], fault and
// fault_window (tests/support/toys.hpp); records: what is written in every window; says: lines for the log in every
// window; grows: bytes of memory more in every window.

#include <sys/resource.h>

#include <cstdio>

#include "coupler/record/archive.hpp"
#include "coupler/record/point_series.hpp"
#include "coupler/record/table.hpp"
#include "tests/support/toys.hpp"

namespace {

//! Results of a chosen kind: what was sent at the end of each window.
class Results
{
 public:
    Results(std::size_t kind, std::size_t points, sluice::Participant const& self)
    {
        auto const base = self.directory() / self.name();
        std::vector<std::string> headers{"time [s]"};
        for (std::size_t i = 0; i < points; ++i) headers.push_back("place " + std::to_string(i) + " [m]");
        auto const keep = self.resumes() ? std::optional(self.resumed_at()) : std::nullopt;
        if (kind == 1) table_.emplace(base.string() + ".csv", headers, keep);
        if (kind == 2) series_.emplace(self.directory(), self.name(), sluice::Precision::float64, keep);
        if (kind == 3) archive_.emplace(base.string() + ".h5", std::span<sluice::ArchiveFact const>(), keep);
    }
    void append(double time, std::span<std::int64_t const> ids, std::span<double const> values)
    {
        std::vector<double> row{time};
        row.insert(row.end(), values.begin(), values.end());
        if (table_) table_->append(row);
        if (series_) {
            std::vector<double> const places(2 * ids.size());
            sluice::PointColumn const columns[] = {{"position", "m", 2, places}, {"place", "m", 1, values}};
            series_->append(time, ids, columns);
        }
        sluice::ArchiveDataset const datasets[] = {{"place", "m", values, {values.size()}}};
        if (archive_) archive_->append(time, datasets);
    }

 private:
    std::optional<sluice::Table> table_;
    std::optional<sluice::PointSeries> series_;
    std::optional<sluice::Archive> archive_;
};

void stream(sluice::Participant& self)
{
    auto r = self.config();
    auto const points = static_cast<std::size_t>(r.integer_or("points", 1, {.min = 1}));
    auto fault = toys::Fault::read(r);
    auto const records = r.choice_or("records", 0, {"nothing", "table", "series", "archive"});
    auto const says = r.integer_or("says", 0, {.min = 0});
    auto grows = static_cast<std::size_t>(r.integer_or("grows", 0, {.min = 0}));
    self.sends({"place"});
    self.takes({"place"});
    r.finish();
    if (self.checking()) return;
    fault.spare(self.resumes());
    if (self.resumes()) grows = 0;
    std::vector<std::int64_t> ids(points);
    std::vector<double> values(points);
    for (std::size_t i = 0; i < points; ++i) ids[i] = static_cast<std::int64_t>(i);
    double sum = 0;
    self.keeps([&](sluice::State& state) { state.put_number("sum", sum); },
               [&](sluice::State const& state) { sum = state.number("sum"); });
    auto const tell = [&](double value) {
        values.assign(points, value);
        for (auto const& to : self.receivers("place")) self.write(to, "place", ids, {values});
    };
    tell(0);
    std::vector<std::vector<char>> memory;
    std::optional<Results> results;
    for (sluice::Window const& window : self.windows()) {
        if (!results) results.emplace(records, points, self);
        for (std::int64_t line = 0; line < says; ++line)
            std::printf("window %lld, line %lld\n", static_cast<long long>(window.index), static_cast<long long>(line));
        if (grows > 0) memory.emplace_back(grows, 'x');
        double const more = fault.strike(window.index);
        for (auto const& from : self.senders("place"))
            sum += self.read(from, "place", window).columns(window.end)[0][0];
        tell(static_cast<double>(window.index + 1) + more);
        results->append(window.end, ids, values);
    }
    rusage used = {};
    ::getrusage(RUSAGE_SELF, &used);
    self.fact("sum", sum);
    self.fact("memory [kB]", static_cast<double>(used.ru_maxrss));
}

}  // namespace

int main(int argc, char** argv)
{
    return sluice::run(argc, argv, stream);
}
