//! Cost of a checkpoint of 64 MB, step by step, beside writing and syncing the same bytes to the same folder. Prints a
//! table; `--json FILE` writes a list of {case, metric, value, unit, against, ratio}. `--small`: a smoke run.
//! `--folder DIR`: where to write, else the current folder, because /tmp may be in memory.
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <vector>

#include "coupler/base/state.hpp"
#include "coupler/record/checkpoint.hpp"

namespace {

using Clock = std::chrono::steady_clock;
constexpr double goal = 0.3;  // s for 64 MB

nlohmann::json results = nlohmann::json::array();

//! ratio = value / what it stands against.
void note(char const* metric, double seconds, char const* against, double ratio)
{
    std::printf("%-46s %10.2f ms %8.2f x %s\n", metric, 1e3 * seconds, ratio, against);
    results.push_back({{"case", "checkpoint"},
                       {"metric", metric},
                       {"value", seconds},
                       {"unit", "s"},
                       {"against", against},
                       {"ratio", ratio}});
}

double seconds_of(std::function<void()> const& action)
{
    auto const start = Clock::now();
    action();
    return std::chrono::duration<double>(Clock::now() - start).count();
}

double median(std::vector<double> times)
{
    std::sort(times.begin(), times.end());
    return times[times.size() / 2];
}

//! The least that brings bytes to the disk: one file, one write, one fsync.
void write_raw(std::filesystem::path const& file, std::vector<std::byte> const& bytes)
{
    int const descriptor = ::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
    std::size_t done = 0;
    while (descriptor >= 0 && done < bytes.size()) {
        auto const count = ::write(descriptor, bytes.data() + done, bytes.size() - done);
        if (count <= 0) break;
        done += static_cast<std::size_t>(count);
    }
    if (done < bytes.size() || ::fsync(descriptor) != 0 || ::close(descriptor) != 0) {
        std::perror(file.c_str());
        std::exit(7);
    }
}

//! As a fluid of nine populations a cell has it, and some small ones.
sluice::State sample(std::size_t bytes)
{
    std::vector<double> values(bytes / sizeof(double) / 9);
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = 1.0 / static_cast<double>(i + 1);
    sluice::State state;
    for (int q = 0; q < 9; ++q) state.put("population/" + std::to_string(q), values);
    state.put_integer("step", 12345);
    return state;
}

}  // namespace

int main(int argc, char** argv)
{
    std::size_t bytes = 64u << 20;
    int repeats = 7;
    char const* json = nullptr;
    std::filesystem::path parent = std::filesystem::current_path();
    for (int i = 1; i < argc; ++i) {
        if (std::strcmp(argv[i], "--small") == 0) bytes = 1u << 20, repeats = 3;
        if (std::strcmp(argv[i], "--json") == 0 && i + 1 < argc) json = argv[++i];
        if (std::strcmp(argv[i], "--folder") == 0 && i + 1 < argc) parent = argv[++i];
    }
    auto const folder = parent / ("checkpoint_bench." + std::to_string(::getpid()));
    sluice::CheckpointStore const store(folder, 2);
    store.prepare();
    auto const state = sample(bytes);
    auto const plain = state.encode();
    std::vector<double> raw, encode, write, commit, verify, restore, whole;
    bool same = true;
    for (int repeat = 0; repeat < repeats; ++repeat) {
        raw.push_back(seconds_of([&] { write_raw(folder / "raw", plain); }));
        std::filesystem::remove(folder / "raw");
        sluice::CheckpointPart part;
        sluice::FoundCheckpoint found;
        sluice::Manifest manifest{
            .version = "0", .scene = 1, .window = repeat, .ticks = 0, .tick = 1, .previous = {}, .members = {}};
        encode.push_back(seconds_of([&] { same = same && state.pieces().pieces.size() > state.size(); }));
        write.push_back(seconds_of([&] { part = store.write_part(repeat, "fluid", state); }));
        manifest.members.push_back(part);
        commit.push_back(seconds_of([&] { store.commit(manifest); }));
        verify.push_back(seconds_of([&] { found = store.newest(); }));
        restore.push_back(seconds_of(
            [&] { same = same && sluice::State::decode(store.read_part(*found.manifest, "fluid"), "part") == state; }));
        whole.push_back(write.back() + commit.back() + verify.back());
    }
    std::filesystem::remove_all(folder);
    double const floor = median(raw);
    note("raw write and fsync of the same bytes", floor, "itself", 1);
    note("of the next line: heads, XXH3, no copy", median(encode), "raw", median(encode) / floor);
    note("part: encode, write, fsync, rename, sync, XXH3", median(write), "raw", median(write) / floor);
    note("commit: manifest, 3 syncs, prune", median(commit), "raw", median(commit) / floor);
    note("verify: read all, XXH3", median(verify), "raw", median(verify) / floor);
    note("encode, write, commit and verify", median(whole), "raw", median(whole) / floor);
    note("the same against the goal", median(whole), "0.3 s", median(whole) / goal);
    note("restore: read, XXH3 twice, decode, compare", median(restore), "raw", median(restore) / floor);
    if (json) std::ofstream(json) << results.dump(1) << '\n';
    if (!same) std::puts("the state that came back is another one");
    return same ? 0 : 1;
}
