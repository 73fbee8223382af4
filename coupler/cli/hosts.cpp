#include "coupler/cli/hosts.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <random>

#include "coupler/base/error.hpp"
#include "coupler/base/scratch_directory.hpp"
#include "coupler/cli/check.hpp"
#include "coupler/cli/process.hpp"
#include "coupler/cli/start.hpp"
#include "coupler/record/atomic_file.hpp"

namespace sluice {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr std::size_t last_words = 5;  // of a program that does not reach its host

//! What the other host's shell looks at, and says in lines that no greeting of a host has. Its words: current
//! directory, program, scene, a file in the directory of the run, what that file holds.
constexpr char const* look =
    R"sh(cd "$1" 2>/dev/null || echo "sluice: no $1: the current directory"; )sh"
    R"sh([ -r "$3" ] || echo "sluice: no $3: the scene"; )sh"
    R"sh(command -v "$2" >/dev/null || echo "sluice: no $2: the program"; )sh"
    R"sh([ -z "$5" ] || [ "$(cat "$4" 2>/dev/null)" = "$5" ] || )sh"
    R"sh(echo "sluice: no ${4%/.sluice/*} with what is in it here: the directory of the run"; )sh"
    R"sh(echo "sluice: looked")sh";

//! A question to one host on behalf of one participant.
struct Question
{
    ParticipantSpec const& spec;
    fs::path answer;
    Process process;
};

//! Makes a file in the directory of the run that no other directory has.
std::string leave_mark(fs::path const& file)
{
    std::random_device random;
    auto const mark = fmt::format("{:08x}{:08x}", random(), random());
    write_atomically(file, mark + "\n");
    return mark;
}

std::string joined(std::vector<std::string> const& words)
{
    std::string text;
    for (auto const& word : words) text += (text.empty() ? "" : " ") + word;
    return text;
}

//! Empty: all is there. Else what is not, a line each.
std::string problems_of(Question& question, std::string const& reach, Clock::time_point deadline)
{
    while (!question.process.poll(std::chrono::milliseconds(100)) && Clock::now() < deadline) {
    }
    auto const ending = question.process.poll();
    auto const text = read_file(question.answer);
    std::string problems;
    bool looked = false;
    for (std::size_t at = 0; at < text.size();) {
        auto const end = std::min(text.find('\n', at), text.size());
        auto const line = text.substr(at, end - at);
        at = end + 1;
        looked = looked || line == "sluice: looked";
        if (line.starts_with("sluice: no ")) problems += "\n    " + std::string(line.substr(8));
    }
    if (looked && ending) return problems;
    auto const said = last_lines(question.answer, last_words);
    auto const what = !ending               ? std::string("it does not answer")
                      : ending->signal != 0 ? fmt::format("ended by signal {}", ending->signal)
                                            : fmt::format("exit {}", ending->code);
    return fmt::format("\n    it cannot be reached by `{}`: {}{}{}", reach, what,
                       said.empty() ? "" : ", and says:", said);
}

}  // namespace

void require_hosts(Scene const& scene, fs::path const& directory)
{
    auto const& all = scene.participants;
    if (std::all_of(all.begin(), all.end(), [](auto const& spec) { return is_this_machine(spec.host); })) return;
    ScratchDirectory const answers("sluice-hosts");
    auto const mark_file = fs::absolute(directory / ".sluice" / "here").lexically_normal();
    std::string mark;
    std::vector<Question> questions;
    for (auto const& spec : all) {
        if (is_this_machine(spec.host)) continue;
        if (!directory.empty() && mark.empty()) mark = leave_mark(mark_file);
        auto const argv = remotely(scene, spec.host,
                                   {"sh", "-c", look, "sluice", fs::current_path().string(), program_there(spec)[0],
                                    fs::absolute(scene.file).lexically_normal().string(), mark_file.string(), mark});
        auto const answer = answers.path() / spec.name;
        questions.push_back({spec, answer, Process(argv, answer)});
    }
    auto const deadline = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                             std::chrono::duration<double>(scene.connect_timeout));
    std::string problems;
    for (auto& question : questions) {
        auto reach = scene.remote;
        reach.push_back(question.spec.host);
        auto const found = problems_of(question, joined(reach), deadline);
        if (!found.empty())
            problems += "\n  " + question.spec.host + ", for participant \"" + question.spec.name + "\":" + found;
    }
    require(problems.empty(), [&] {
        return Error(scene.file.string() +
                         ": the run cannot be started on other hosts (needed: the same paths there, on a file system "
                         "that they share with this one)." +
                         problems + "\n  Or start those participants by hand, each with an --out of its host.",
                     Exit::io);
    });
}

}  // namespace sluice
