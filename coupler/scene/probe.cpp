#include "coupler/scene/probe.hpp"

#include <algorithm>
#include <map>
#include <sstream>

#include "coupler/scene/scene.hpp"

namespace sluice {
namespace {

//! Scenes that lead the readers through all of their branches; they need not be good ones.
constexpr char const* probes[] = {
    R"(sluice: 1
title: first
dimension: 2
frame: {rotating: {}}
time: {end: 1, window: 0.1, pace: a}
output: {interval: 1}
data: {x: {columns: {position: {shape: vector, unit: m}}}}
participants: {a: {solver: s, host: 10.0.0.1, config: {}}, b: {command: c}}
couplings: [{from: a, to: b, data: x, lag: 1, region: {min: [0, 0], max: [1, 1]}}]
implicit: [{participants: [a, b], tolerance: {x: 0.1}}]
checkpoint: {}
ledger: {energy: {}}
timeouts: {}
address: ipc
port: 7000
security: {keys: k}
remote: ssh
)",
    R"(sluice: 1
title: second
dimension: 3
frame: {rotating: {}}
time: {end: 2}
output: {interval: 2}
participants: {a: {solver: s, host: 10.0.0.1}, b: {solver: s}}
couplings: [{from: a, to: b, data: kinematics, lag: 1, region: {min: [0, 0, 0], max: [1, 1, 1]}}]
implicit: [{participants: [a, b], tolerance: 0.1}]
port: 7000
security: insecure
)",
    "sluice: 1\ntime: {end: 1}\nparticipants: {a: {solver: s}}\n"};

//! "participants.grains.solver" -> "participants.*.solver", "couplings[0].lag" -> "couplings[].lag".
std::string pattern_of(std::string const& path, std::vector<std::string> const& named)
{
    std::stringstream parts(path);
    std::string so_far, pattern;
    for (std::string part; std::getline(parts, part, '.');) {
        bool const a_name = std::find(named.begin(), named.end(), so_far) != named.end();
        so_far += (so_far.empty() ? "" : ".") + part;
        auto const bracket = part.find('[');
        auto const word = a_name ? "*" : bracket == part.npos ? part : part.substr(0, bracket) + "[]";
        pattern += (pattern.empty() ? "" : ".") + word;
    }
    return pattern;
}

//! Two askings for one key, in one of all askings.
void merge(Key& known, Key const& again)
{
    known.required = known.required && again.required;
    known.largest = std::max(known.largest, again.largest);
    known.size = std::min(known.size, again.size);
    if (known.fallback != again.fallback) known.fallback.reset();
}

}  // namespace

std::vector<Key> scene_keys()
{
    std::vector<Key> keys;
    for (std::size_t n = 0; n < std::size(probes); ++n) {
        std::vector<Key> asked;
        load_scene_text(probes[n], "probe" + std::to_string(n) + ".yaml", {}, &asked);
        std::vector<std::string> named;
        for (Key const& key : asked)
            if (key.kind == Key::Kind::named) named.push_back(key.path);
        for (Key key : asked) {
            bool const is_named = std::find(named.begin(), named.end(), key.path) != named.end();
            if (is_named && key.kind == Key::Kind::mapping) continue;  // looked at again
            key.path = pattern_of(key.path, named);
            if (key.path.ends_with('*')) continue;  // its parent says so
            key.largest = key.size;
            auto const known = std::find_if(keys.begin(), keys.end(),
                                            [&](Key const& k) { return k.path == key.path && k.kind == key.kind; });
            if (known == keys.end())
                keys.push_back(key);
            else
                merge(*known, key);
        }
    }
    return keys;
}

}  // namespace sluice
