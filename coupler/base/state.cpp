#include "coupler/base/state.hpp"

#include <algorithm>
#include <cstring>

#include "coupler/base/error.hpp"

namespace sluice {
namespace {

constexpr char const* type_names[] = {"numbers", "integers", "bytes"};

std::span<std::byte const> bytes_of(auto const& array)
{
    return std::visit([](auto const& values) { return std::as_bytes(std::span(values)); }, array);
}

//! A name that may be anything, fit for a message.
std::string shown(std::string_view name)
{
    std::string text(name.substr(0, longest_state_name));
    for (char& c : text)
        if (c < ' ' || c > '~') c = '?';
    return text;
}

}  // namespace

bool is_state_name(std::string_view name)
{
    return !name.empty() && name.size() <= longest_state_name &&
           name.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-.:/") ==
               std::string_view::npos;
}

template <class Value>
void State::insert(std::string_view name, std::span<Value const> values)
{
    require(is_state_name(name), [&] {
        return Error("state: \"" + shown(name) +
                         "\" is no name for an array (1 to 200 letters, digits, _ - . : /). Rename it in the solver.",
                     Exit::internal);
    });
    bool const fresh = arrays_.try_emplace(std::string(name), std::vector<Value>(values.begin(), values.end())).second;
    require(fresh, [&] {
        return Error("state: \"" + std::string(name) + "\" was put twice (needs one array a name). Rename one of them.",
                     Exit::internal);
    });
}

void State::put(std::string_view name, std::span<double const> numbers)
{
    insert(name, numbers);
}

void State::put(std::string_view name, std::span<std::int64_t const> integers)
{
    insert(name, integers);
}

void State::put(std::string_view name, std::span<std::byte const> bytes)
{
    insert(name, bytes);
}

template <class Value>
std::vector<Value> const& State::find(std::string_view name) const
{
    auto const found = arrays_.find(name);
    auto const needed = type_names[Array(std::vector<Value>()).index()];
    require(found != arrays_.end(), [&] {
        return Error(where_ + ": \"" + std::string(name) + "\" is not in it (needs " + needed +
                         " of that name). Was it written by another version of the solver?",
                     Exit::io);
    });
    auto const* values = std::get_if<std::vector<Value>>(&found->second);
    require(values != nullptr, [&] {
        return Error(where_ + ": \"" + std::string(name) + "\" holds " + type_names[found->second.index()] +
                         " (needs " + needed + "). Was it written by another version of the solver?",
                     Exit::io);
    });
    return *values;
}

template <class Value>
std::vector<Value> const& State::find(std::string_view name, std::size_t size) const
{
    auto const& values = find<Value>(name);
    require(values.size() == size, [&] {
        return Error(where_ + ": \"" + std::string(name) + "\" has " + std::to_string(values.size()) +
                         " values (needs " + std::to_string(size) + "). Does it belong to another scene?",
                     Exit::io);
    });
    return values;
}

std::span<double const> State::numbers(std::string_view name) const
{
    return find<double>(name);
}

std::span<std::int64_t const> State::integers(std::string_view name) const
{
    return find<std::int64_t>(name);
}

std::span<std::byte const> State::bytes(std::string_view name) const
{
    return find<std::byte>(name);
}

std::span<double const> State::numbers(std::string_view name, std::size_t size) const
{
    return find<double>(name, size);
}

std::span<std::int64_t const> State::integers(std::string_view name, std::size_t size) const
{
    return find<std::int64_t>(name, size);
}

double State::number(std::string_view name) const
{
    return find<double>(name, 1)[0];
}

std::int64_t State::integer(std::string_view name) const
{
    return find<std::int64_t>(name, 1)[0];
}

std::string State::text(std::string_view name) const
{
    auto const& values = find<std::byte>(name);
    return {reinterpret_cast<char const*>(values.data()), values.size()};
}

void State::nest(std::string_view prefix, State inner)
{
    while (!inner.arrays_.empty()) {
        auto node = inner.arrays_.extract(inner.arrays_.begin());
        node.key() = std::string(prefix) + "/" + node.key();
        require(is_state_name(node.key()) && !has(node.key()), [&] {
            return Error("state: \"" + shown(node.key()) + "\" is taken or no name for an array. Use another prefix.",
                         Exit::internal);
        });
        arrays_.insert(std::move(node));
    }
}

State State::take(std::string_view prefix)
{
    std::string const start = std::string(prefix) + "/";
    State inner;
    inner.where_ = where_ + ", " + std::string(prefix);
    for (auto next = arrays_.lower_bound(start); next != arrays_.end() && next->first.starts_with(start);) {
        auto node = arrays_.extract(next++);
        node.key().erase(0, start.size());
        inner.arrays_.insert(std::move(node));
    }
    return inner;
}

bool State::operator==(State const& other) const
{
    auto const same = [](auto const& a, auto const& b) {
        auto const x = bytes_of(a.second), y = bytes_of(b.second);
        return a.first == b.first && a.second.index() == b.second.index() && x.size() == y.size() &&
               (x.empty() || std::memcmp(x.data(), y.data(), x.size()) == 0);
    };
    return std::equal(arrays_.begin(), arrays_.end(), other.arrays_.begin(), other.arrays_.end(), same);
}

}  // namespace sluice
