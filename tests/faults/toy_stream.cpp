// One sends, one takes, nothing comes back: so the sender may run ahead. Keys: points (sent), nap [s].

#include <sys/resource.h>

#include "tests/support/toys.hpp"

namespace {

void stream(sluice::Participant& self)
{
    auto r = self.config();
    auto const points = static_cast<std::size_t>(r.integer_or("points", 1, {.min = 1}));
    auto const fault = toys::Fault::read(r);
    self.sends({"place"});
    self.takes({"place"});
    r.finish();
    if (self.checking()) return;
    std::vector<std::int64_t> ids(points);
    std::vector<double> values(points);
    for (std::size_t i = 0; i < points; ++i) ids[i] = static_cast<std::int64_t>(i);
    auto const tell = [&](double value) {
        values.assign(points, value);
        for (auto const& to : self.receivers("place")) self.write(to, "place", ids, {values});
    };
    double sum = 0;
    tell(0);
    for (sluice::Window const& window : self.windows()) {
        fault.strike(window.index);
        for (auto const& from : self.senders("place"))
            sum += self.read(from, "place", window).columns(window.end)[0][0];
        tell(static_cast<double>(window.index + 1));
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
