// Which build of a solver is started, and that nothing but the file changes by it.

#include "packaging/level.hpp"

#include <doctest/doctest.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/support/shell.hpp"

namespace {

namespace fs = std::filesystem;

//! bin/solver chooses; lib/sluice/LEVEL/solver reports.
struct Tree
{
    fs::path root, bin, solver, levels;
    Tree()
    {
        char pattern[] = "/tmp/sluice-test-XXXXXX";
        root = ::mkdtemp(pattern);
        bin = root / "bin", solver = bin / "solver", levels = root / "lib/sluice";
        fs::create_directories(bin);
        fs::copy_file(CHOOSE, solver);
        for (auto const name : {"x86-64", "x86-64-v3", "x86-64-v4"}) {
            fs::create_directories(levels / name);
            fs::copy_file(REPORT, levels / name / "solver");
        }
    }
    Tree(Tree const&) = delete;
    Tree& operator=(Tree const&) = delete;
    ~Tree()
    {
        std::error_code ignored;
        fs::remove_all(root, ignored);
    }

    struct Ran
    {
        int status = 0;
        pid_t pid = 0;
        std::string output;
    };
    //! As `called`, with a parent-death signal like a child of `sluice run`.
    Ran run(std::vector<std::string> words, char const* isa = nullptr)
    {
        auto const log = root / "log";
        std::vector<char*> argv;
        for (auto& word : words) argv.push_back(word.data());
        argv.push_back(nullptr);
        Ran ran;
        ran.pid = ::fork();
        if (ran.pid == 0) {
            int const file = ::open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
            ::dup2(file, 1);
            ::dup2(file, 2);
            ::setenv("LEVEL_TEST", "handed on", 1);
            isa ? ::setenv("SLUICE_ISA", isa, 1) : ::unsetenv("SLUICE_ISA");
            ::prctl(PR_SET_PDEATHSIG, SIGUSR2);
            ::execv(solver.c_str(), argv.data());
            ::_exit(126);
        }
        ::waitpid(ran.pid, &ran.status, 0);
        ran.output = shell::slurp(log);
        return ran;
    }
};

bool has(std::string const& text, std::string const& part)
{
    return text.find(part) != std::string::npos;
}

}  // namespace

TEST_CASE("level: the best that the processor has, or the one wanted")
{
    level::Level const old[] = {{"x86-64", true}, {"x86-64-v3", true}, {"x86-64-v4", false}};
    CHECK(level::choose(old, "").name == "x86-64-v3");
    CHECK(level::choose(old, "x86-64").name == "x86-64");
    level::Level const current[] = {{"x86-64", true}, {"x86-64-v3", true}, {"x86-64-v4", true}};
    CHECK(level::choose(current, "").name == "x86-64-v4");
    CHECK(level::choose(current, "x86-64-v3").name == "x86-64-v3");
}

TEST_CASE("level: what the processor lacks and what does not exist are refused, with what is possible")
{
    level::Level const old[] = {{"x86-64", true}, {"x86-64-v3", true}, {"x86-64-v4", false}};
    auto const lacking = level::choose(old, "x86-64-v4");
    CHECK_FALSE(lacking.name);
    CHECK(lacking.why_not ==
          "SLUICE_ISA=x86-64-v4: this processor does not have it (possible here: x86-64, x86-64-v3). Unset it to take "
          "the best.");
    CHECK(has(level::choose(old, "avx2").why_not, "SLUICE_ISA=avx2: no such instruction set (possible here: x86-64,"));
}

TEST_CASE("choose_level: name, words, environment, process and parent-death signal stay, the file is the level's")
{
    Tree tree;
    auto const ran = tree.run({"called so", "scene.yaml", "--as"}, "x86-64");
    CAPTURE(ran.output);
    CHECK(ran.status == 0);
    CHECK(has(ran.output, "called called so\n"));
    CHECK(has(ran.output, "pid " + std::to_string(ran.pid) + "\n"));
    CHECK(has(ran.output, "parent-death signal " + std::to_string(SIGUSR2) + "\n"));
    CHECK(has(ran.output, "environment handed on\n"));
    CHECK(has(ran.output, "file " + fs::canonical(tree.levels / "x86-64/solver").string() + "\n"));
    CHECK(has(ran.output, "word scene.yaml\nword --as\n"));
}

TEST_CASE("choose_level: without SLUICE_ISA one of the levels is started, through a link too")
{
    Tree tree;
    auto const link = tree.root / "link";
    fs::create_symlink(tree.solver, link);
    tree.solver = link;
    auto const ran = tree.run({"solver"});
    CHECK(ran.status == 0);
    CHECK(has(ran.output, "file " + fs::canonical(tree.levels).string() + "/x86-64"));
}

TEST_CASE("choose_level: exit code and signal are the solver's")
{
    Tree tree;
    auto const left = tree.run({"solver", "exit", "6"});
    CHECK(WIFEXITED(left.status));
    CHECK(WEXITSTATUS(left.status) == 6);
    auto const ended = tree.run({"solver", "signal", std::to_string(SIGTERM)});
    CHECK(WIFSIGNALED(ended.status));
    CHECK(WTERMSIG(ended.status) == SIGTERM);
}

TEST_CASE("choose_level: exits with 2 for a level that is none, with 7 and the file's name if it is missing")
{
    Tree tree;
    auto const none = tree.run({"solver"}, "x86-64-v9");
    CHECK(WEXITSTATUS(none.status) == 2);
    CHECK(has(none.output, "SLUICE_ISA=x86-64-v9: no such instruction set (possible here: x86-64"));
    fs::remove(tree.levels / "x86-64/solver");
    auto const missing = tree.run({"solver"}, "x86-64");
    CHECK(WEXITSTATUS(missing.status) == 7);
    CHECK(has(missing.output, "lib/sluice/x86-64/solver: No such file or directory"));
}
