// What a complete coupling layer is told: pace, hosts, regions, implicit groups, checkpoints, ledger, security.

#include "tests/coupler/scene/mistakes.hpp"
#include "tests/support/changed.hpp"

using namespace sluice;
using namespace scene_text;

namespace {

//! A scene with every key there is, on two hosts.
std::string const full = R"(sluice: 1
title: everything
dimension: 2
time: {end: 1.0, window: 0.01, pace: water}
data:
  heat: {columns: {position: {shape: vector, unit: m}, value: {unit: K}}}
  level: {columns: {value: {unit: m}}, meshless: true}
participants:
  grains: {solver: dem, host: 10.0.0.1}
  water: {solver: lbm, host: 10.0.0.2, ranks: 4}
  basin: {command: [basin, --fast], host: node-3.cluster}
couplings:
  - {from: grains, to: water, data: kinematics, region: {min: [0, 0], max: [1, 1]}}
  - {from: water, to: grains, data: load, lag: 1, predict: quadratic, sample: hold}
  - {from: water, to: basin, data: level, lag: 1}
implicit:
  - {participants: [grains, water], method: aitken, relaxation: 0.3, history: 4, max_iterations: 20, tolerance: {load: 1.0e-4, load.torque: 1.0e-3}}
checkpoint: {interval: 0, windows: 100, keep: 3}
on-death: restart
ledger: {tolerance: 1.0e-8, on-violation: stop, energy: {every: 3, tolerance: 0.2}}
transport: zmq
port: 7000
security: {keys: my-keys}
remote: [ssh, -o, BatchMode=yes]
)";

LoadedScene load(std::string const& text, std::vector<std::string> const& overrides = {})
{
    in_threads::Scratch scratch;
    std::ofstream(scratch.path() / "s.yaml") << text;
    auto loaded = load_scene(scratch.path() / "s.yaml", overrides);
    loaded.diagnostics->throw_if_any();
    return loaded;
}

}  // namespace

TEST_CASE("scene: every key reads as written")
{
    auto const loaded = load(full);
    Scene const& s = loaded.scene;
    CHECK(s.pace == 1);
    CHECK(s.participants.at(0).host == "10.0.0.1");
    CHECK(s.participants.at(1).ranks == 4);
    CHECK(s.participants.at(2).command == std::vector<std::string>{"basin", "--fast"});
    REQUIRE(s.edges.at(0).region.has_value());
    CHECK(s.edges[0].region->max == std::array<double, 3>{1, 1, 0});
    CHECK_FALSE(s.edges.at(1).region.has_value());
    REQUIRE(s.implicit.size() == 1);
    CHECK(s.implicit[0].participants == std::vector<int>{0, 1});
    CHECK(s.implicit[0].method == ImplicitGroup::Method::aitken);
    CHECK(s.implicit[0].relaxation == 0.3);
    CHECK(s.implicit[0].history == 4);
    CHECK(s.implicit[0].max_iterations == 20);
    CHECK(s.implicit[0].tolerances == std::map<std::string, double>{{"load", 1e-4}, {"load.torque", 1e-3}});
    CHECK(s.data.back().name == "level");
    CHECK(s.data.back().meshless);
    CHECK(s.checkpoint.interval == 0);
    CHECK(s.checkpoint.windows == 100);
    CHECK(s.checkpoint.keep == 3);
    CHECK(s.restart_on_death);
    CHECK(s.ledger_tolerance == 1e-8);
    CHECK(s.energy_every == 3);
    CHECK(s.energy_tolerance == 0.2);
    CHECK(s.on_violation == OnViolation::stop);
    CHECK(s.transport == TransportKind::zmq);
    CHECK(s.port == 7000);
    CHECK(s.keys.filename() == "my-keys");
    CHECK_FALSE(s.insecure);
    CHECK(s.remote == std::vector<std::string>{"ssh", "-o", "BatchMode=yes"});
}

TEST_CASE("scene: what is not given has its default, and the first that waits for nobody has the pace")
{
    auto const s = load(with("gravity: [0, -9.81]\n", "")).scene;
    CHECK(s.pace == 0);
    CHECK(s.implicit.empty());
    CHECK(s.checkpoint.interval == 600);
    CHECK(s.checkpoint.keep == 2);
    CHECK_FALSE(s.restart_on_death);
    CHECK(s.ledger_tolerance == 1e-9);
    CHECK(s.energy_every == 199);
    CHECK(s.energy_tolerance == 0.1);
    CHECK(s.on_violation == OnViolation::warn);
    CHECK(s.transport == TransportKind::automatic);
    CHECK(load(changed(with(", lag: 1", ""), "data: kinematics", "data: kinematics, lag: 1")).scene.pace == 1);
}

TEST_CASE("scene: a default that is written out is no other scene")
{
    auto const plain = load(good).scene;
    auto const written =
        load(good + "checkpoint: {interval: 600, keep: 2}\nledger: {energy: {every: 199}}\non-death: stop\n").scene;
    CHECK(plain.hash == written.hash);
    CHECK(plain.hash != load(good + "on-death: restart\n").scene.hash);
}

TEST_CASE("scene: mistakes in the keys of a complete coupling layer, each with its place and advice")
{
    struct Case
    {
        std::string from, to, place, says;
    };
    Case const cases[] = {
        {"pace: water", "pace: watr",
         "4:38: ", "time.pace = watr (there is no such participant: grains, water, basin)"},
        {"meshless: true", "meshless: maybe", "7:50: ", "(must be true or false)"},
        {"unit: K}}}", "unit: K}}, meshless: true}", "6:20: ", "meshless data have no place in space"},
        {"ranks: 4", "ranks: 0", "10:47: ", "(must be >= 1 and <= 256)"},
        {"ranks: 4", "ranks: 257", "10:47: ", "(must be >= 1 and <= 256)"},
        {"host: 10.0.0.1", "host: -oProxyCommand=x", "9:31: ", "is not an address or a name of a host"},
        {", host: 10.0.0.1", "", "9:3: ", "\"water\" on 10.0.0.2 cannot reach a participant that listens on this host"},
        {"host: 10.0.0.1", "host: localhost", "9:25: ", "cannot reach a participant"},
        {"max: [1, 1]", "max: [1, 0]", "13:71: ", "y is not above that of min"},
        {"max: [1, 1]", "max: [1, 1, 1]", "13:76: ", "must be a list of 2 numbers, in m"},
        {"max: [1, 1]", "mx: [1, 1]", "13:71: ", "Did you mean max?"},
        {"data: load,", "data: load, region: {min: [0, 0], max: [1, 1]},", "14:43: ", "load has no column position"},
        {"participants: [grains, water]", "participants: [grains, watr]", "17:29: ", "Did you mean water?"},
        {"participants: [grains, water]", "participants: [grains]",
         "17:20: ", "a list of 1 (must be a list of at least"},
        {"participants: [grains, water]", "participants: [grains, grains]", "17:29: ", "stands here twice"},
        {"participants: [grains, water]", "participants: [grains, basin]",
         "17:6: ", "no coupling between grains, basin"},
        {"data: load, lag: 1, predict: quadratic", "data: load, lag: 0", "12:1: ", "circle"},
        {"method: aitken", "method: iqn_ils", "17:45: ", "Did you mean iqn-ils?"},
        {"relaxation: 0.3", "relaxation: 0", "17:65: ", "(must be > 0 and <= 1)"},
        {"load.torque: 1", "load.toque: 1", "17:128: ", "Did you mean load.torque?"},
        {"{load: 1.0e-4, load.torque: 1.0e-3}", "1.5", "17:113: ", "(must be > 0 and < 1)"},
        {"windows: 100", "windows: 0", "19:1: ", "restart without checkpoints"},
        {"keep: 3", "keep: 0", "18:47: ", "(must be >= 1"},
        {"on-violation: stop", "on-violation: halt", "20:43: ", "must be one of: warn, stop, off"},
        {"port: 7000\n", "", "1:1: ", "port: is missing"},
        {"port: 7000", "port: 65530", "22:7: ", "is too high: 6 processes"},
        {"security: {keys: my-keys}\n", "", "1:1: ", "Give security: {keys: DIR}"},
        {"security: {keys: my-keys}", "security: insecre", "23:11: ", "Did you mean insecure?"},
        {"security: {keys: my-keys}", "security: {key: my-keys}", "23:12: ", "Did you mean keys?"},
        {"transport: zmq", "transport: shm", "21:12: ", "contradicts hosts"},
        {"transport: zmq", "transport: mpi", "21:12: ", "contradicts hosts"},
        {"transport: zmq", "address: tcp://127.0.0.1:7000", "21:1: ", "contradicts hosts"},
        {"remote: [ssh, -o, BatchMode=yes]", "remote: []", "24:9: ", "(must be a text, or a list of texts)"},
    };
    for (Case const& c : cases) {
        CAPTURE(c.to);
        auto const found = mistakes(changed(full, c.from, c.to));
        CHECK(has(found, c.says));
        CHECK(has("\n" + found, "\n" + c.place));
    }
}

TEST_CASE("scene: keys that only mean something beside hosts are refused without them")
{
    CHECK(has(mistakes(good + "port: 7000\n"), "10:1: port: has no meaning while no participant has a host"));
    CHECK(has(mistakes(good + "remote: ssh\n"), "10:1: remote: has no meaning"));
    CHECK(has(mistakes(good + "security: insecure\n"), "10:1: security: has no meaning"));
    CHECK(mistakes(with("solver: dem", "solver: dem, host: 127.0.0.1") + "port: 7000\n").empty());
    CHECK(mistakes(with("solver: lbm", "solver: lbm, host: node2") + "port: 7000\n").find("cannot reach") !=
          std::string::npos);
}

TEST_CASE("scene: implicit groups are disjoint and hold a coupling with a lag")
{
    auto const two = good + "implicit:\n  - {participants: [grains, water]}\n  - {participants: [water, grains]}\n";
    CHECK(has(mistakes(two), "12:6: implicit[1].participants: water is in another group too"));
    auto const one_way = with("  - {from: water, to: grains, data: load, lag: 1}\n", "");
    CHECK(has(mistakes(one_way + "implicit:\n  - {participants: [grains, water]}\n"), "no coupling with lag: 1"));
}

TEST_CASE("scene: columns count characters, not bytes")
{
    auto const text = with("gravity: [0, -9.81]", "title: \"K\xc3\xb6rner \xe2\x86\x92 \xf0\x9f\x8c\x8a\"");
    CHECK(mistakes(text).empty());
    auto const flow = with("{end: 1.0, window: auto}", "{ \"\xc3\xa4\": 1, end: -1}");
    CHECK(has("\n" + mistakes(flow), "\n2:9: time.\xc3\xa4 is not a key"));
    CHECK(has("\n" + mistakes(flow), "\n2:22: time.end = -1 s"));
    CHECK(has("\n" + mistakes("\xef\xbb\xbf" + flow), "\n2:22: time.end = -1 s"));
}

TEST_CASE("scene: --set on what an alias shows changes that place alone")
{
    auto const text = with("{solver: dem}", "{solver: dem, config: &c {a: {b: 1}, c: 2}}");
    auto const aliased = changed(text, "{solver: lbm}", "{solver: lbm, config: *c}");
    auto loaded = load(aliased, {"participants.water.config.a.b=7"});
    CHECK(loaded.configs.at(0).child("a").number("b") == 1);
    CHECK(loaded.configs.at(1).child("a").number("b") == 7);
    CHECK(loaded.configs.at(1).number("c") == 2);
    auto const scalar = changed(changed(good, "end: 1.0", "end: &e 1.0"), "grains: {solver: dem}",
                                "grains: {solver: dem, config: {x: *e}}");
    auto other = load(scalar, {"time.end=0.5", "couplings.1.lag=1"});
    CHECK(other.scene.end == 0.5);
    CHECK(other.configs.at(0).number("x") == 1);
}

TEST_CASE("scene: a mistake beside a path that --set copied keeps its line")
{
    auto const text = changed(with("{solver: dem}", "{solver: dem, config: &c {a: 1}}"), "{solver: lbm}",
                              "{solver: lbm, config: *c, rank: 2}");
    CHECK(
        has("\n" + mistakes(text, {"participants.water.config.a=7"}), "\n6:36: participants.water.rank is not a key"));
}
