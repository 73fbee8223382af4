//! Writes the seeds whose form is ours: `fuzz_seeds DIRECTORY` makes DIRECTORY/state/valid-mixed and so on. To be run
//! again, over tests/fuzz/corpus, when a format changes.
#include <vector>

#include "coupler/base/state.hpp"
#include "coupler/record/atomic_file.hpp"
#include "coupler/record/manifest.hpp"
#include "coupler/record/recording.hpp"
#include "tests/fuzz/frames.hpp"

using namespace sluice;

namespace {

void write_states(std::filesystem::path const& folder)
{
    State state;
    write_atomically(folder / "valid-empty", state.encode());
    state.put("position", std::vector<double>{1, 2, 3});
    state.put("id", std::vector<std::int64_t>{4});
    state.put("empty", std::vector<double>{});
    state.put_text("solver/note", "text");
    auto const encoded = state.encode();
    write_atomically(folder / "valid-mixed", encoded);
    write_atomically(folder / "invalid-cut", std::span(encoded).first(encoded.size() - 64));
}

void write_manifests(std::filesystem::path const& folder)
{
    Manifest manifest{
        .version = "0.1.0", .scene = 1, .window = 0, .ticks = 0, .tick = 1, .previous = {}, .members = {}};
    manifest.members = {{"a", 0, {}}};
    write_atomically(folder / "valid-small", manifest.text());
    manifest = {
        .version = "0.1.0", .scene = ~0ull, .window = 40, .ticks = -7, .tick = 1e-5, .previous = 30, .members = {}};
    manifest.members = {{"grains", 1'000'000, {1, 2}}, {"water:0", 64, {3, 4}}, {"water:10", 7, {5, 6}}};
    write_atomically(folder / "valid-ranks", manifest.text());
    write_atomically(folder / "invalid-cut", manifest.text().substr(0, 300));
}

void write_recordings(std::filesystem::path const& folder)
{
    std::vector<std::byte> const message(20, std::byte{7});
    Recording recording(folder / "valid-two", 1, "time.end = 1\n");
    recording.append(0, 0, message);
    recording.append(1, -1, {});
    recording.close();
    auto const whole = read_file(folder / "valid-two");
    write_atomically(folder / "invalid-cut", whole.substr(0, whole.size() - 30));
}

void write_frames(std::filesystem::path const& folder)
{
    FrameEncoder encoder(fuzz::load, fuzz::dimension, 0);
    auto write = [&](char const* name, fuzz::Sample const& frame) {
        write_atomically(folder / name, fuzz::encoded(encoder, frame).bytes);
    };
    write("valid-whole", {});
    write("valid-one-column", {.index = 1, .torque = {9, 6}});
    fuzz::Sample const shorter_frame{.index = 2, .ids = {3}, .force = {1, 2}, .torque = {5}};
    auto const message = fuzz::encoded(encoder, shorter_frame);
    auto const shorter = message.bytes;
    write_atomically(folder / "valid-fewer-points", shorter);
    write_atomically(folder / "invalid-cut", shorter.first(shorter.size() - 4));
    write_atomically(folder / "text", encode_text({.kind = MessageKind::abort, .session = 1, .frame = 2}, "why"));
}

//! Steps of fuzz_handshake: 0 greets, 3 plans, 4 VALUE sends a frame, 6 says goodbye, 7 is lost, 8 begins anew, 10
//! repeats, 11 ENTRY TEXT changes its greetings, 12 VALUE iterates, 14 says a verdict, 15 a power.
void write_handshakes(std::filesystem::path const& folder)
{
    auto write = [&](char const* name, std::initializer_list<std::uint8_t> steps) {
        write_atomically(folder / name, std::as_bytes(std::span(steps.begin(), steps.size())));
    };
    write("valid-told", {1, 0, 4, 1, 3, 4, 2, 3, 4, 3, 3, 4, 4, 6});
    write("valid-pacing", {0, 0, 4, 1, 4, 2, 4, 3, 4, 4, 6});
    write("valid-started-again", {1, 1, 3, 1, '7', 7, 8, 5, 7, 0, 4, 1, 3, 4, 2, 3, 4, 3, 3, 4, 4, 6});
    write("invalid-doubled", {1, 0, 4, 1, 10, 3, 4, 2, 3, 4, 3, 3, 4, 4, 6});
    write("invalid-other-name", {1, 1, 4, 3, '"', 'x', '"', 4, 1, 3, 4, 2});
    write("invalid-not-met", {1, 4, 1, 3, 4, 2, 3, 4, 3, 3, 4, 4, 6});
    write("valid-group-reads", {2, 0, 4, 1, 4, 2, 12, 2, 12, 2, 4, 2, 4, 2, 6});
    write("valid-group-told", {3, 0, 4, 1, 3,  4, 2, 14, 0, 0, 5, 5, 5, 0, 0, 0, 0, 12, 3, 14, 1, 0, 5, 5, 0, 1, 1, 0,
                               0, 3, 4, 3, 14, 0, 0, 5,  5, 0, 0, 0, 0, 0, 3, 4, 4, 14, 0, 0,  5, 5, 0, 0, 0, 0, 0, 6});
    write("valid-loads", {4, 0, 4, 1, 15, 4, 0, 0, 0, 0, 4, 1, 15, 4, 1, 0, 1, 0, 4, 2, 15, 4, 2, 0, 2, 0, 4, 3, 6});
    write("valid-motion", {5, 0, 4, 1, 3, 4, 2, 3, 4, 3, 3, 4, 4, 6});
    write("valid-box", {4,   11,  10,  17,  '[', '[', '0', ',', '0', ',', '0', ']', ',', '[', '1', ',', '1',
                        ',', '1', ']', ']', 0,   4,   1,   15,  4,   0,   0,   0,   0,   4,   1,   15,  4,
                        0,   0,   0,   0,   4,   1,   15,  4,   0,   0,   0,   0,   4,   1,   6});
    write("valid-tiny-step", {1,   11,  2, 4, 't', 'r', 'u', 'e', 11, 9, 6, '1', 'e', '-', '3',
                              '0', '0', 0, 4, 1,   3,   4,   2,   3,  4, 3, 3,   4,   4,   6});
    write("invalid-whole-number", {1, 11, 6, 5, '1', 'e', '3', '0', '0', 0, 4, 1, 3, 4, 2, 3, 4, 3, 3, 4, 4, 6});
    // 5 KIND SESSION EDGE COLUMNS FRAME TICKS POINTS ITERATION TEXT: a checkpoint that nobody can store, a window that
    // begins where none has ended, a frame of another time
    write("invalid-checkpoint", {1, 0, 4, 1, 5, 6, 0, 0, 2, 8, 8, 7, 0, 0, 4, 2, 6});
    write("invalid-late-window", {1, 0, 4, 1, 5, 6, 0, 0, 1, 8, 9, 7, 0, 0, 4, 2, 6});
    write("invalid-early-frame", {1, 0, 4, 1, 3, 5, 2, 0, 0, 0, 9, 8, 1, 0, 0, 3, 4, 3, 3, 4, 4, 6});
    write("invalid-any", {1, 0, 4, 1, 5, 2, 2, 0, 1, 9, 9, 1, 0, 2, 7, 7});
}

}  // namespace

int main(int argc, char** argv)
{
    if (argc != 2) return 2;
    std::filesystem::path const corpus(argv[1]);
    write_states(corpus / "state");
    write_manifests(corpus / "manifest");
    write_recordings(corpus / "recording");
    write_frames(corpus / "frame");
    write_handshakes(corpus / "handshake");
}
