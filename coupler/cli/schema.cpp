#include "coupler/cli/schema.hpp"

#include <cmath>
#include <cstdio>

#include "coupler/cli/commands.hpp"
#include "coupler/record/atomic_file.hpp"
#include "coupler/scene/probe.hpp"
#include "coupler/scene/scene.hpp"

namespace sluice {
namespace {

using Json = nlohmann::ordered_json;

constexpr double largest_whole = 9.0e15;  // what the reader takes for a whole number

Json const any_scalar = {"string", "number", "boolean"};

class Builder
{
 public:
    Builder() : keys_(scene_keys()) {}

    Json object(std::string const& pattern) const
    {
        Json schema = {{"type", "object"}, {"additionalProperties", false}};
        Json required = Json::array(), properties = Json::object();
        for (Key const& key : keys_) {
            auto const name = child_name(key.path, pattern);
            if (name.empty() || properties.contains(name)) continue;
            properties[name] = described(key.path);
            if (key.required) required.push_back(name);
        }
        if (!required.empty()) schema["required"] = required;
        schema["properties"] = properties;
        return ruled(schema, pattern);
    }

 private:
    //! "end" of "time.end" in "time"; empty if it is not a child.
    static std::string child_name(std::string const& path, std::string const& parent)
    {
        auto const prefix = parent.empty() ? "" : parent + ".";
        if (!path.starts_with(prefix)) return {};
        auto const name = path.substr(prefix.size());
        return name.find('.') == name.npos ? name : "";
    }

    static Json ruled(Json schema, std::string const& pattern)
    {
        for (auto const& [where, rule] : rules())
            if (where == pattern) schema.update(rule);
        return schema;
    }

    //! A key with its meaning, unit and default; where it is read in two ways, either.
    Json described(std::string const& path) const
    {
        Json ways = Json::array();
        Json schema = Json::object();
        for (auto const& [pattern, meaning] : meanings())
            if (pattern == path) schema["description"] = meaning;
        for (Key const& key : keys_) {
            if (key.path != path) continue;
            ways.push_back(value(key));
            if (key.fallback) schema["default"] = parsed(key);
        }
        if (ways.size() == 1)
            schema.update(ways[0]);
        else
            schema["anyOf"] = ways;
        return ruled(schema, path);
    }

    static Json parsed(Key const& key)
    {
        bool const is_text =
            key.kind == Key::Kind::text || key.kind == Key::Kind::word || key.kind == Key::Kind::choice;
        auto const value = is_text ? Json(Json::value_t::discarded) : Json::parse(*key.fallback, nullptr, false);
        return value.is_discarded() ? Json(*key.fallback) : value;
    }

    static Json number(Key const& key, bool whole)
    {
        auto const tidy = [](double x) {
            return x == std::floor(x) && std::abs(x) <= largest_whole ? Json(static_cast<std::int64_t>(x)) : Json(x);
        };
        Json schema = {{"type", whole ? "integer" : "number"}};
        auto add = [&](char const* word, double bound) {
            if (std::isfinite(bound)) schema[word] = tidy(bound);
        };
        add("exclusiveMinimum", key.bounds.above);
        add("minimum", std::isfinite(key.bounds.min) || !whole ? key.bounds.min : -largest_whole);
        add("maximum", std::isfinite(key.bounds.max) || !whole ? key.bounds.max : largest_whole);
        add("exclusiveMaximum", key.bounds.below);
        if (key.words.empty()) return schema;
        return {{"anyOf", {{{"enum", key.words}}, schema}}};
    }

    Json value(Key const& key) const
    {
        using Kind = Key::Kind;
        switch (key.kind) {
            case Kind::number:
                return number(key, false);
            case Kind::integer:
                return number(key, true);
            case Kind::flag:
                return {{"type", "boolean"}};
            case Kind::text:
                return {{"type", any_scalar}, {"minLength", 1}};
            case Kind::word:
                return {{"type", "string"}, {"minLength", 1}};
            case Kind::name:
                return {{"type", any_scalar}};
            case Kind::choice:
                return {{"enum", key.words}};
            case Kind::texts: {
                Json const text = {{"type", any_scalar}, {"minLength", 1}};
                return {{"anyOf", {text, {{"type", "array"}, {"items", text}, {"minItems", 1}}}}};
            }
            case Kind::names:
                return {{"type", "array"},
                        {"items", {{"type", any_scalar}}},
                        {"minItems", key.size},
                        {"uniqueItems", true}};
            case Kind::numbers:
                return {{"type", "array"},
                        {"items", number(key, false)},
                        {"minItems", key.size},
                        {"maxItems", key.largest}};
            case Kind::mapping:
                return object(key.path);
            case Kind::named:
                return {{"type", "object"}, {"additionalProperties", object(key.path + ".*")}};
            case Kind::list:
                return {{"type", "array"}, {"items", object(key.path + "[]")}};
            case Kind::number_map:
                return {{"type", "object"}, {"additionalProperties", number(key, false)}};
            case Kind::open:
                return {{"type", "object"}};
        }
        return true;
    }

    std::vector<Key> keys_;
};

//! Is all of a path but its last key in the scene? Only then does --set accept it.
bool has_parent(YAML::Node node, std::string const& path)
{
    for (std::size_t begin = 0, end = path.find('.'); end != path.npos; begin = end + 1, end = path.find('.', begin)) {
        auto const part = path.substr(begin, end - begin);
        auto const child = node.IsSequence() ? node[std::stoul(part)] : node[part];
        if (!child.IsDefined() || !(child.IsMap() || child.IsSequence())) return false;
        node.reset(child);
    }
    return true;
}

//! "couplings[0].lag" -> "couplings.0.lag", as --set has it.
std::string set_path(std::string const& path)
{
    std::string text;
    for (char c : path)
        if (c != ']') text += c == '[' ? '.' : c;
    return text;
}

//! Every path that --set can change in a scene, a line each: those that hold a value, not keys of their own.
std::string settable_paths(std::filesystem::path const& scene)
{
    using Kind = Key::Kind;
    std::vector<Key> keys;
    auto const text = read_scene_file(scene);
    load_scene_text(text, scene, {}, &keys);
    auto const root = YAML::Load(text);
    std::string lines = "\n";
    for (Key const& key : keys) {
        bool const value =
            key.kind != Kind::mapping && key.kind != Kind::named && key.kind != Kind::list && key.kind != Kind::open;
        auto const path = set_path(key.path);
        if (value && has_parent(root, path) && lines.find("\n" + path + "\n") == lines.npos) lines += path + "\n";
    }
    return lines.substr(1);
}

}  // namespace

Json scene_schema()
{
    Json schema = {{"$schema", "http://json-schema.org/draft-07/schema#"},
                   {"title", "Sluice scene"},
                   {"description", "Who takes part in a coupled run and what flows between them. SI units."}};
    schema.update(Builder().object(""));
    return schema;
}

int schema_command(Options const& o)
{
    auto const text = o.paths_in.empty() ? scene_schema().dump(1) + "\n" : settable_paths(o.paths_in);
    if (o.page.empty())
        std::fputs(text.c_str(), stdout);
    else
        write_atomically(o.page, text);
    return 0;
}

}  // namespace sluice
