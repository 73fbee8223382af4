#include "coupler/cli/start.hpp"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <netdb.h>
#include <netinet/in.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <memory>

#include "coupler/base/error.hpp"
#include "coupler/cli/check.hpp"

namespace sluice {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> command(Scene const& scene, ParticipantSpec const& spec, fs::path const& directory,
                                 Begin begin, bool remote)
{
    auto argv = remote ? program_there(spec) : program_of(spec);
    auto const place = [&](fs::path const& p) { return remote ? fs::absolute(p).lexically_normal() : p; };
    argv.insert(argv.end(), {place(scene.file).string(), "--as", spec.name, "--out", place(directory).string()});
    if (begin == Begin::resumed) argv.emplace_back("--resume");
    for (auto const& change : scene.overrides) argv.insert(argv.end(), {"--set", change});
    return argv;
}

//! mpirun and its options.
std::vector<std::string> mpirun_words()
{
    std::vector<std::string> argv{"mpirun", "--oversubscribe", "--bind-to", "none"};
    if (::geteuid() == 0) argv.emplace_back("--allow-run-as-root");
    return argv;
}

std::vector<std::string> mpirun()
{
    require(!find_executable("mpirun").empty(), [] {
        return Error(
            "mpirun is not on PATH (needed for transport: mpi and for ranks). Install the package openmpi-bin.",
            Exit::io);
    });
    return mpirun_words();
}

void append(std::vector<std::string>& argv, std::vector<std::string> const& more)
{
    argv.insert(argv.end(), more.begin(), more.end());
}

//! What a program on another host needs to be as one here: the current directory, and the variables of this program. It
//! ends with the connection that it came by, mpirun too, which does not ask for that itself.
std::vector<std::string> as_here(std::vector<std::string> const& program, bool is_mpirun)
{
    std::vector<std::string> words{"env", "-C", fs::current_path().string()};
    for (char** variable = environ; *variable; ++variable)
        if (std::string_view(*variable).starts_with("SLUICE_")) words.emplace_back(*variable);
    words.push_back(std::string(parent_death) + "=1");
    if (is_mpirun) {
        for (auto const& [name, value] : mpirun_environment()) words.push_back(name + "=" + value);
        append(words, {"setpriv", "--pdeathsig", "KILL"});
    }
    append(words, program);
    return words;
}

Job job_of(Scene const& scene, std::size_t participant, fs::path const& directory, Begin begin)
{
    auto const& spec = scene.participants[participant];
    Job job{.argv = {}, .log = directory / (spec.name + ".log"), .members = {}};
    job.remote = !is_this_machine(spec.host);
    job.mpirun = spec.ranks > 1;
    std::vector<std::string> words;
    if (job.mpirun) words = job.remote ? mpirun_words() : mpirun();
    if (job.mpirun) append(words, {"-np", std::to_string(spec.ranks)});
    append(words, command(scene, spec, directory, begin, job.remote));
    job.argv = job.remote ? remotely(scene, spec.host, as_here(words, job.mpirun)) : words;
    return job;
}

//! Every numeric address of `host`; itself if it has none.
std::vector<std::string> addresses_of(std::string const& host)
{
    addrinfo hints = {};
    hints.ai_socktype = SOCK_STREAM;
    addrinfo* list = nullptr;
    std::vector<std::string> found{host};
    if (::getaddrinfo(host.c_str(), nullptr, &hints, &list) != 0) return found;
    std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> const guard(list, ::freeaddrinfo);
    for (auto const* a = list; a; a = a->ai_next) {
        char text[NI_MAXHOST] = {};
        if (::getnameinfo(a->ai_addr, a->ai_addrlen, text, sizeof text, nullptr, 0, NI_NUMERICHOST) == 0)
            found.emplace_back(text);
    }
    return found;
}

std::vector<std::string> own_addresses()
{
    std::vector<std::string> found;
    ifaddrs* list = nullptr;
    if (::getifaddrs(&list) != 0) return found;
    std::unique_ptr<ifaddrs, decltype(&::freeifaddrs)> const guard(list, ::freeifaddrs);
    for (auto const* i = list; i; i = i->ifa_next) {
        if (!i->ifa_addr) continue;
        auto const family = i->ifa_addr->sa_family;
        auto const size = family == AF_INET ? sizeof(sockaddr_in) : family == AF_INET6 ? sizeof(sockaddr_in6) : 0;
        char text[NI_MAXHOST] = {};
        if (size > 0 && ::getnameinfo(i->ifa_addr, static_cast<socklen_t>(size), text, sizeof text, nullptr, 0,
                                      NI_NUMERICHOST) == 0)
            found.emplace_back(text);
    }
    return found;
}

}  // namespace

std::vector<std::string> program_there(ParticipantSpec const& spec)
{
    auto words = program_of(spec);
    if (words[0].find('/') != std::string::npos) words[0] = fs::absolute(words[0]).lexically_normal().string();
    return words;
}

std::vector<std::string> remotely(Scene const& scene, std::string const& host, std::vector<std::string> const& program)
{
    require(!scene.remote.empty(), [&] {
        return Error(scene.file.string() + ": " + host +
                     " is another host, and the scene does not say how to start a program there. Give remote: [ssh] "
                     "or [srun, -N1, -n1, -w], or start that participant by hand.");
    });
    auto const name = fs::path(scene.remote[0]).filename().string();
    auto argv = scene.remote;
    argv.push_back(host);
    append(argv, name.ends_with("sh") ? quoted_for_shell(program) : program);
    return argv;
}

bool is_this_machine(std::string const& host)
{
    if (host.empty() || host == "localhost" || host.starts_with("127.")) return true;
    char name[256] = {};
    if (::gethostname(name, sizeof name - 1) == 0 && host == name) return true;
    auto const own = own_addresses();
    auto const all = addresses_of(host);
    return std::any_of(all.begin(), all.end(),
                       [&](auto const& a) { return std::find(own.begin(), own.end(), a) != own.end(); });
}

std::vector<std::string> quoted_for_shell(std::vector<std::string> const& words)
{
    std::vector<std::string> quoted{"exec"};  // no shell stays between the program and the connection
    for (auto const& word : words) {
        std::string text = "'";
        for (char const c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
        quoted.push_back(text + "'");
    }
    return quoted;
}

std::vector<Job> jobs_of(Scene const& scene, std::vector<CrewMember> const& members, fs::path const& directory,
                         Begin begin)
{
    std::vector<Job> jobs;
    if (scene.transport == TransportKind::mpi && members.size() > 1) {  // one mpirun, each participant a program of it
        Job job{.argv = mpirun(), .log = directory / "mpirun.log", .members = {}, .mpirun = true};
        for (std::size_t p = 0; p < scene.participants.size(); ++p) {
            if (p > 0) job.argv.emplace_back(":");
            append(job.argv, {"-np", std::to_string(scene.participants[p].ranks)});
            append(job.argv, command(scene, scene.participants[p], directory, begin, false));
        }
        jobs.push_back(std::move(job));
    } else
        for (std::size_t p = 0; p < scene.participants.size(); ++p) jobs.push_back(job_of(scene, p, directory, begin));
    for (std::size_t m = 0; m < members.size(); ++m)
        jobs[jobs.size() == 1 ? 0 : static_cast<std::size_t>(members[m].participant)].members.push_back(m);
    return jobs;
}

void remove_old_results(Scene const& scene, fs::path const& directory)
{
    std::vector<std::string> names{"series.csv", "summary.json", "archive.h5",
                                   "trace.json", "report.html",  scene.file.stem().string() + ".pvd"};
    for (auto const& spec : scene.participants)
        for (std::string const ending : {".csv", ".pvd", ".h5", ".log"}) names.push_back(spec.name + ending);
    for (auto const& name : names) fs::remove(directory / name);
    for (auto const& spec : scene.participants) fs::remove_all(directory / spec.name);
    fs::remove_all(directory / "checkpoints");
    std::error_code none;
    for (auto const& entry : fs::directory_iterator(directory / ".sluice", none)) {
        auto const name = entry.path().filename().string();
        for (std::string const ending : {".status", ".json", ".config", ".trace.json"})
            if (name.ends_with(ending) && name != "run.json") fs::remove(entry.path(), none);
    }
}

fs::path part_summary(fs::path const& directory, std::string const& member, int part)
{
    return directory / ".sluice" / (member + ".part" + std::to_string(part) + ".json");
}

void put_part_aside(Scene const& scene, fs::path const& directory, int part)
{
    std::error_code none;
    for (auto const& member : members_of_crew(scene)) {
        auto const own = directory / ".sluice" / member.name;
        fs::remove(own.string() + ".status", none);
        fs::rename(own.string() + ".json", part_summary(directory, member.name, part), none);
    }
}

}  // namespace sluice
