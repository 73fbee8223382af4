// on-death: restart with grains and water: what was recorded is that of a run in which nobody died, row by row.

#include "tests/support/launched.hpp"

using namespace launched;

namespace {

//! configs/immersed_column.yaml made small: 60 grains, 750 windows, a checkpoint every 30.
std::string small_column()
{
    auto text = shell::slurp(CONFIGS "/immersed_column.yaml");
    std::pair<std::string, std::string> const changes[] = {
        {"transport: auto", "on-death: restart\ncheckpoint: {windows: 30}"},
        {"count: 1000", "count: 60"},
        {"cell: 1.0e-4", "cell: 2.0e-4"},
        {"end: 0.6", "end: 0.03"},
        {"interval: 0.0125", "interval: 0.005"}};
    for (auto const& [from, to] : changes) {
        REQUIRE(text.find(from) != text.npos);
        text.replace(text.find(from), from.size(), to);
    }
    return text;
}

}  // namespace

TEST_CASE("restart goals: grains or water die, the other goes back, and the series is that of an undisturbed run")
{
    auto const text = small_column();
    Case whole(text);
    REQUIRE(whole.run().exit == 0);
    for (std::string const victim : {"grains", "water"}) {
        CAPTURE(victim);
        Case c(text);
        shell::Background run(c.command(), c.log());
        int const pid = c.pid_in_window(victim, 100);
        REQUIRE(pid > 0);
        ::kill(pid, SIGKILL);
        CHECK(run.wait(200).exit == 0);
        CHECK(summary(c).value("restarts", 0) == 1);
        CHECK(shell::slurp(c.out() + "/series.csv") == shell::slurp(whole.out() + "/series.csv"));
        for (std::string const part : {"/grains", "/water"})
            CHECK(std::distance(std::filesystem::directory_iterator(c.out() + part), {}) ==
                  std::distance(std::filesystem::directory_iterator(whole.out() + part), {}));
    }
}
