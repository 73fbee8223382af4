#include "coupler/record/checkpoint.hpp"

#include <doctest/doctest.h>

#include <random>

#include "coupler/base/error.hpp"
#include "tests/coupler/record/checkpoints.hpp"
#include "tests/coupler/record/damage.hpp"
#include "tests/coupler/record/folder.hpp"
#include "tests/support/fault_row.hpp"

using namespace sluice;
using namespace sluice::test;

TEST_CASE("checkpoint: what was written comes back, with the generation before named")
{
    Folder const folder;
    CheckpointStore const store(folder / "run", 2);
    CHECK_FALSE(store.newest().manifest);
    CHECK_FALSE(std::filesystem::exists(folder / "run"));  // looking makes nothing
    store.prepare();
    CHECK(write_checkpoint(store, 10).empty());
    CHECK(trusted_window(store) == 10);
    CHECK_FALSE(store.newest().manifest->previous);
    CHECK(write_checkpoint(store, 20).empty());
    auto const found = store.newest();
    CHECK(found.note.empty());
    REQUIRE(found.manifest);
    CHECK(found.manifest->window == 20);
    CHECK(found.manifest->previous == 10);
    CHECK(store.read_manifest(20) == *found.manifest);
    CHECK(found.manifest->ticks == 20'000);
    CHECK(found.manifest->scene == 0x1234'5678'9abc'def0);
    CHECK(trusted_window(store) == 20);
    CHECK(has(io_error([&] { store.read_part(*found.manifest, "water"); }), "has no part of \"water\""));
}

TEST_CASE("checkpoint: a state is written without a copy, and is the same file")
{
    Folder const folder;
    CheckpointStore const store(folder.path(), 2);
    store.prepare();
    auto const bytes = part_of(10, "grains");
    auto const by_bytes = store.write_part(10, "grains", bytes);
    auto const text = read_file(store.part_file(10, "grains"));
    auto const by_state = store.write_part(10, "grains", State::decode(bytes, "part"));
    CHECK(by_state == by_bytes);
    CHECK(read_file(store.part_file(10, "grains")) == text);
}

TEST_CASE("checkpoint: parts without a manifest do not count, and are removed once they are older")
{
    Folder const folder;
    CheckpointStore const store(folder.path(), 2);
    store.prepare();
    write_checkpoint(store, 10);
    store.write_part(20, "grains", part_of(20, "grains"));
    auto const found = store.newest();
    CHECK(found.manifest->window == 10);
    CHECK(found.note ==
          "checkpoint of window 20 is passed over: it was never completed.\ngoing on from the one of window 10.");
    store.write_part(40, "grains", part_of(40, "grains"));  // somebody is ahead already
    write_checkpoint(store, 30);
    CHECK_FALSE(std::filesystem::exists(store.part_file(20, "grains").parent_path()));
    CHECK(std::filesystem::exists(store.part_file(40, "grains")));
    CHECK(trusted_window(store) == 30);
    CHECK(store.newest().manifest->previous == 10);
}

TEST_CASE("checkpoint: keeps so many complete generations, and leaves what is not its own")
{
    for (int const keep : {1, 2, 3}) {
        Folder const folder;
        CheckpointStore const store(folder.path(), keep);
        store.prepare();
        std::filesystem::create_directory(store.directory() / "007");
        std::filesystem::create_directory(store.directory() / "notes");
        for (std::int64_t window = 1; window <= 6; ++window) {
            write_checkpoint(store, window);
            for (std::int64_t older = 1; older <= window; ++older)
                CHECK(std::filesystem::exists(store.manifest_file(older)) == (older > window - keep));
        }
        CHECK(std::filesystem::exists(store.directory() / "007"));
        CHECK(std::filesystem::exists(store.directory() / "notes"));
    }
}

TEST_CASE("checkpoint: a resumed run writes again what came after, nothing old is mixed in")
{
    Folder const folder;
    CheckpointStore const store(folder.path(), 3);
    store.prepare();
    for (std::int64_t const window : {10, 20, 30}) write_checkpoint(store, window);
    store.write_part(40, "grains", part_of(40, "grains"));
    store.discard_after(10);
    CHECK(trusted_window(store) == 10);
    CHECK_FALSE(std::filesystem::exists(store.directory() / "20"));
    CHECK_FALSE(std::filesystem::exists(store.directory() / "40"));
    write_checkpoint(store, 15);
    CHECK(store.newest().manifest->previous == 10);
}

TEST_CASE("checkpoint: a report that does not fit what is there is not committed")
{
    Folder const folder;
    CheckpointStore const store(folder.path(), 2);
    store.prepare();
    write_checkpoint(store, 10);
    auto manifest = manifest_of(20);
    for (auto const& member : members) manifest.members.push_back(store.write_part(20, member, part_of(20, member)));
    manifest.members[1].bytes += 1;
    CHECK(has(io_error([&] { store.commit(manifest); }), "water:0.part: "));
    manifest.members[1].bytes -= 1;
    std::filesystem::remove(store.part_file(20, "water:1"));
    CHECK(has(io_error([&] { store.commit(manifest); }), "water:1.part: cannot open: No such file or directory"));
    CHECK(trusted_window(store) == 10);
    CHECK_THROWS_AS(store.write_part(20, "../escape", State()), Error);
    CHECK_THROWS_AS(store.write_part(-1, "grains", State()), Error);
}

TEST_CASE("checkpoint: 10 000 cuts and flipped bits are all found, and the generation before is taken")
{
    Folder const folder(memory_folder());
    CheckpointStore const store(folder.path(), 2);
    store.prepare();
    write_checkpoint(store, 10, 3);
    write_checkpoint(store, 20, 3);
    std::vector<std::filesystem::path> files{store.manifest_file(20)};
    for (auto const& member : members) files.push_back(store.part_file(20, member));
    std::mt19937_64 random(22);
    Row row("F22", "damaged checkpoint files found, the one before taken", {.brief = 10'000, .stated = 10'000});
    while (row.next()) {
        Damage const damage(files[random() % files.size()], random);
        auto const found = store.newest();
        bool const fell_back = found.manifest && found.manifest->window == 10 &&
                               found.note.starts_with("checkpoint of window 20 is passed over: ") &&
                               found.note.ends_with("going on from the one of window 10.");
        CHECK_MESSAGE(fell_back, damage.text() << ": " << found.note);
    }
    CHECK(trusted_window(store, 3) == 20);  // mended
}

TEST_CASE("checkpoint: damage after the look is found when the part is read")
{
    Folder const folder;
    CheckpointStore const store(folder.path(), 1);
    store.prepare();
    write_checkpoint(store, 10);
    auto const found = store.newest();
    std::mt19937_64 random(23);
    for (int repeat = 0; repeat < 200; ++repeat) {
        Damage const damage(store.part_file(10, "grains"), random);
        auto const said = io_error([&] { store.read_part(*found.manifest, "grains"); });
        CHECK_MESSAGE(said.find("grains.part: ") != std::string::npos, damage.text() << ": " << said);
    }
    CHECK(store.read_part(*found.manifest, "grains") == part_of(10, "grains"));  // mended
}

TEST_CASE("checkpoint: when no generation is whole, it says why for each")
{
    Folder const folder;
    CheckpointStore const store(folder.path(), 2);
    store.prepare();
    write_checkpoint(store, 10);
    write_checkpoint(store, 20);
    write_atomically(store.manifest_file(20), "{}");
    std::filesystem::remove(store.part_file(10, "grains"));
    std::filesystem::create_directory(store.part_file(10, "grains"));
    auto const found = store.newest();
    CHECK_FALSE(found.manifest);
    CHECK(has(found.note, "window 20 is passed over: " + store.manifest_file(20).string() + ": cut off"));
    CHECK(
        has(found.note, "window 10 is passed over: " + store.part_file(10, "grains").string() + ": not a plain file"));
    CHECK(has(found.note, "no complete checkpoint"));
}

TEST_CASE("checkpoint: a manifest of another window is not taken for this one's")
{
    Folder const folder;
    CheckpointStore const store(folder.path(), 2);
    store.prepare();
    write_checkpoint(store, 10);
    std::filesystem::rename(store.directory() / "10", store.directory() / "99");
    CHECK(has(store.newest().note, "of window 10 (needs 99)"));
}
