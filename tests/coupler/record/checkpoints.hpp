#pragma once

#include <doctest/doctest.h>

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "coupler/base/error.hpp"
#include "coupler/base/state.hpp"
#include "coupler/record/checkpoint.hpp"

//! Checkpoints of a run with three processes, whose contents follow from the window.
namespace sluice::test {

inline std::vector<std::string> const members = {"grains", "water:0", "water:1"};

inline std::vector<std::byte> part_of(std::int64_t window, std::string const& member, std::size_t values = 40)
{
    State state;
    state.put_integer("window", window);
    state.put_text("member", member);
    std::vector<double> numbers(values);
    for (std::size_t i = 0; i < values; ++i) numbers[i] = static_cast<double>(window) + 0.1 * static_cast<double>(i);
    state.put("numbers", numbers);
    return state.encode();
}

inline Manifest manifest_of(std::int64_t window)
{
    return {.version = "0.1.0",
            .scene = 0x1234'5678'9abc'def0,
            .window = window,
            .ticks = 1000 * window,
            .tick = 1e-6,
            .previous = {},
            .members = {}};
}

//! Both phases of one window; returns what commit() does.
inline std::string write_checkpoint(CheckpointStore const& store, std::int64_t window, std::size_t values = 40)
{
    auto manifest = manifest_of(window);
    for (auto const& member : members)
        manifest.members.push_back(store.write_part(window, member, part_of(window, member, values)));
    return store.commit(manifest);
}

//! The window of the newest checkpoint that can be trusted, -1 if none, after a look at everything in it.
inline std::int64_t trusted_window(CheckpointStore const& store, std::size_t values = 40)
{
    auto const found = store.newest();
    if (!found.manifest) return -1;
    for (auto const& member : members)
        if (store.read_part(*found.manifest, member) != part_of(found.manifest->window, member, values)) return -2;
    return found.manifest->window;
}

//! What an Error of exit code 7 says; empty: none was thrown.
template <class Action>
std::string io_error(Action&& action)
{
    try {
        action();
    } catch (Error const& error) {
        CHECK(error.exit() == Exit::io);
        return error.what();
    }
    return {};
}

inline bool has(std::string const& text, std::string const& part)
{
    bool const found = text.find(part) != std::string::npos;
    if (!found) MESSAGE("not in: " << text);
    return found;
}

}  // namespace sluice::test
