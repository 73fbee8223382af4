#include "coupler/cli/start.hpp"

#include <arpa/inet.h>
#include <doctest/doctest.h>
#include <unistd.h>

#include "coupler/base/error.hpp"

using namespace sluice;

namespace {

using Words = std::vector<std::string>;

Scene two_hosts(Words remote)
{
    Scene scene;
    scene.file = "/shared/scene.yaml";
    scene.remote = std::move(remote);
    scene.overrides = {"title=it's"};
    scene.participants = {{.name = "left", .solver = "", .command = {"/bin/true"}, .host = "", .ranks = 1, .place = {}},
                          {.name = "right",
                           .solver = "",
                           .command = {"/bin/true", "-x"},
                           .host = "203.0.113.7",  // of the block for documentation: nobody's (RFC 5737)
                           .ranks = 1,
                           .place = {}}};
    return scene;
}

}  // namespace

TEST_CASE("start: a host that is this machine is known by name, loopback and address")
{
    char name[256] = {};
    REQUIRE(::gethostname(name, sizeof name - 1) == 0);
    for (std::string const here : {"", "localhost", "127.0.0.1", "127.8.9.1", static_cast<char const*>(name)})
        CHECK(is_this_machine(here));
    CHECK(!is_this_machine("203.0.113.7"));
}

TEST_CASE("start: on another host the words of remote, the host and the program, quoted for a shell if it is ssh")
{
    std::string const here = std::filesystem::current_path();
    auto const scene = two_hosts({"/usr/bin/ssh", "-o", "BatchMode=yes"});
    auto const jobs = jobs_of(scene, members_of_crew(scene), "/shared/run", Begin::anew);
    REQUIRE(jobs.size() == 2);
    CHECK(!jobs[0].remote);
    CHECK(jobs[0].argv[0] == "/bin/true");
    CHECK(jobs[1].remote);
    CHECK(jobs[1].argv == Words{"/usr/bin/ssh", "-o", "BatchMode=yes", "203.0.113.7", "exec", "'env'", "'-C'",
                                "'" + here + "'", "'SLUICE_END_WITH_PARENT=1'", "'/bin/true'", "'-x'",
                                "'/shared/scene.yaml'", "'--as'", "'right'", "'--out'", "'/shared/run'", "'--set'",
                                "'title=it'\\''s'"});
    auto const slurm = two_hosts({"srun", "-N1", "-w"});
    auto const words = jobs_of(slurm, members_of_crew(slurm), "/shared/run", Begin::resumed)[1].argv;
    CHECK(words == Words{"srun", "-N1", "-w", "203.0.113.7", "env", "-C", here, "SLUICE_END_WITH_PARENT=1", "/bin/true",
                         "-x", "/shared/scene.yaml", "--as", "right", "--out", "/shared/run", "--resume", "--set",
                         "title=it's"});
}

TEST_CASE("start: on another host mpirun ends with its connection, and our variables are set as here")
{
    auto scene = two_hosts({"srun", "-w"});
    scene.participants[1].ranks = 2;
    ::setenv("SLUICE_CACHE", "/shared/cache", 1);
    auto const words = jobs_of(scene, members_of_crew(scene), "/shared/run", Begin::anew)[1].argv;
    ::unsetenv("SLUICE_CACHE");
    auto const at = [&](std::string const& word) {
        return std::find(words.begin(), words.end(), word) - words.begin();
    };
    CHECK(at("SLUICE_CACHE=/shared/cache") < at("setpriv"));
    CHECK(at("OMPI_MCA_mpi_yield_when_idle=1") < at("setpriv"));
    CHECK(at("setpriv") + 3 == at("mpirun"));
    CHECK(at("KILL") + 1 == at("mpirun"));
    CHECK(at("mpirun") < at("/bin/true"));
    CHECK(at("/bin/true") < static_cast<std::ptrdiff_t>(words.size()));
}

TEST_CASE("start: another host without a way to start a program there is a mistake")
{
    auto const scene = two_hosts({});
    try {
        jobs_of(scene, members_of_crew(scene), "/shared/run", Begin::anew);
        CHECK(false);
    } catch (Error const& e) {
        CHECK(std::string(e.what()).find("203.0.113.7 is another host") != std::string::npos);
        CHECK(e.exit() == Exit::config);
    }
}

TEST_CASE("start: several processes of a participant are one mpirun, with transport mpi all of them")
{
    auto scene = two_hosts({});
    scene.participants[1].host = "";
    scene.participants[1].ranks = 3;
    auto const members = members_of_crew(scene);
    REQUIRE(members.size() == 4);
    CHECK(members[3].name == "right:2");
    auto jobs = jobs_of(scene, members, "run", Begin::anew);
    REQUIRE(jobs.size() == 2);
    CHECK(jobs[1].mpirun);
    CHECK(jobs[1].members == std::vector<std::size_t>{1, 2, 3});
    scene.transport = TransportKind::mpi;
    jobs = jobs_of(scene, members, "run", Begin::anew);
    REQUIRE(jobs.size() == 1);
    CHECK(jobs[0].members.size() == 4);
    CHECK(std::count(jobs[0].argv.begin(), jobs[0].argv.end(), "-np") == 2);
}
