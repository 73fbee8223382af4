// Rows F1, F8 and F10 of the fault matrix between two hosts (network namespaces): tests/integration/two_hosts_test.sh.

#include "tests/faults/matrix.hpp"

using namespace matrix;

namespace {

//! One case of the script, so many times. `limit`: the most that its "ended after ... ms" may say [s], 0: it has none.
void repeat(Row& row, std::string const& name, double limit)
{
    in_threads::Scratch scratch;
    while (row.next()) {
        auto const result = shell::run({TWO_HOSTS, name, sluice_command, toy}, scratch.path() / "log", 120);
        if (result.exit == 77) return row.skip(result.output);
        CHECK_MESSAGE(result.exit == 0, result.output);
        auto const at = result.output.find("ended after ");
        if (limit > 0 && at != std::string::npos) row.took(std::stod(result.output.substr(at + 12)) / 1000, limit);
    }
}

}  // namespace

TEST_CASE("F1: kill -9 of a participant on another host: the survivor names it, its process and its host")
{
    Row row("F1", "kill -9 on another host", {.brief = 1, .stated = 50});
    repeat(row, "kill", 2.0 + 1.0);
}

TEST_CASE("F8: nothing passes between two hosts: both sides end, each names the other")
{
    Row row("F8", "partition between two hosts", {.brief = 1, .stated = 50});
    repeat(row, "partition", 2.0 + 1.0);
}

TEST_CASE("F10: 5 % of the packets between two hosts are lost: the same bits")
{
    Row row("F10", "5 % loss between two hosts", {.brief = 1, .stated = 20});
    repeat(row, "loss", 0);
}
