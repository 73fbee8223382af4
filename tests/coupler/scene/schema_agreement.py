"""The JSON Schema and the validator give the same verdict on generated scenes.

    schema_agreement.py SLUICE VERDICTS [--scenes N] [--seed S]

Scenes are drawn at random, good or changed in up to three places, written as YAML and judged twice: by VERDICTS (the
validator, in process) and by the schema that SLUICE prints (python3-jsonschema). What a schema cannot say is listed in
BEYOND, by the validator's words. For each scene:

    no mistakes                       the schema must accept it
    only mistakes of BEYOND           the schema must accept it (a list of what it cannot say, not an excuse)
    only those and of WRITTEN         no verdict (counted)
    any other mistake                 the schema must refuse it
"""
import argparse
import collections
import copy
import json
import random
import re
import subprocess
import sys

try:
    import jsonschema
    import yaml
except ImportError as error:
    print(f"skipped: {error} (packages python3-jsonschema, python3-yaml)")
    sys.exit(77)

# Relations between values, which JSON Schema has no words for.
BEYOND = {
    "names": r"= (?!a mapping|a list|nothing)[^ ]*.* \(there is no such (participant|data)",
    "twice in a list of names": r"stands here twice",  # also uniqueItems: see UNIQUE
    "same coupling": r"this coupling stands here twice",
    "to itself": r"is the same participant as",
    "circle": r"the lag-0 edges form a circle",
    "axis": r"points nowhere",
    "window": r"is longer than the whole run",
    "box": r"is not above that of min",
    "region without position": r"has no column position of shape vector",
    "group without coupling": r"there is nothing to iterate on|no coupling with lag: 1 between",
    "groups overlap": r"is in another group too",
    "tolerance names": r"does not flow inside this group",
    "ports": r"is too high: \d+ processes",
    "reach": r"cannot reach a participant",
}
# How a number is written: a schema sees the parsed number, whatever its type and value then are.
WRITTEN = r"= ([-+]?\.(inf|nan)|0[xo][0-9a-f]+) is (not|neither auto nor) a number"
UNIQUE = r"participants\[\d+\] = .* stands here twice"  # the schema says this one with uniqueItems


class Core(yaml.CSafeLoader):
    """YAML 1.2's core schema, as editors and the validator read: 1e-4 is a number, off and no are texts."""


Core.yaml_implicit_resolvers = {}
for tag, pattern, first in (
        ("bool", r"^(?:true|True|TRUE|false|False|FALSE)$", "tTfF"),
        ("null", r"^(?:~|null|Null|NULL|)$", ["~", "n", "N", ""]),
        ("int", r"^(?:[-+]?[0-9]+|0o[0-7]+|0x[0-9a-fA-F]+)$", "-+0123456789"),
        ("float", r"^(?:[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?|[-+]?\.(?:inf|Inf|INF)|"
                  r"\.(?:nan|NaN|NAN))$", "-+0123456789.")):
    Core.add_implicit_resolver(f"tag:yaml.org,2002:{tag}", re.compile(pattern), list(first))


def whole(loader, node):
    text = loader.construct_scalar(node)
    return int(text[2:], 8) if text.startswith("0o") else int(text, 16) if text.startswith("0x") else int(text)


Core.add_constructor("tag:yaml.org,2002:int", whole)


class Plain(str):
    """Text that is written as it is, without quotes."""


def written(value):
    """Flow YAML of a value: JSON, but for plain words."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{json.dumps(k)}: {written(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(written(v) for v in value) + "]"
    return value if isinstance(value, Plain) else json.dumps(value)


def scene(r):
    """A good scene with a random choice of keys."""
    d = r.choice([2, 2, 3])
    names = ["grains", "water", "soil-1", "basin_2"][:r.randint(1, 4)]
    own = {"heat": {"columns": {"position": {"shape": "vector", "unit": "m"}, "value": {"unit": r.choice(UNITS)}}},
           "level": {"columns": {"value": {"unit": "m"}}, "meshless": True}}
    s = {"sluice": 1, "time": {"end": r.choice([1, 0.5, 2.0, Plain("1e-1")])},
         "participants": {n: participant(r) for n in names}}
    if r.random() < 0.5:
        s["dimension"] = d
    else:
        d = 2
    if r.random() < 0.5:
        s["gravity"] = [0.0] * (d - 1) + [-9.81]
    if r.random() < 0.5:
        s["data"] = own
    kinds = ["kinematics", "load", "phase", "body_force"] + (["heat", "level"] if "data" in s else [])
    couplings = [{"from": a, "to": b, "data": r.choice(kinds), **terms(r, names.index(a) < names.index(b), d)}
                 for a in names for b in names if a != b and r.random() < 0.6]
    for c in couplings:
        if c.get("region") and c["data"] not in ("kinematics", "phase", "heat"):
            del c["region"]
    if couplings and r.random() < 0.9:
        s["couplings"] = couplings
    options(r, s, names)
    if r.random() < 0.3:
        hosts(r, s)
    return s


UNITS = ["K", "W/m2/K", "1", "m s^-1", "kg/m3", "N*m", "mm", "kPa", "-", "1/s", "%", "deg"]


def participant(r):
    p = {"solver": r.choice(["dem", "lbm", "my-solver"])} if r.random() < 0.8 else {
        "command": r.choice(["./run", ["python3", "x.py", Plain("5")]])}
    if r.random() < 0.3:
        p["ranks"] = r.choice([1, 2, 256])
    if r.random() < 0.3:
        p["config"] = {"anything": [1, {"goes": True}]}
    return p


def terms(r, forward, d):
    t = {} if forward else {"lag": 1}
    if t and r.random() < 0.5:
        t["predict"] = r.choice(["none", "linear", "quadratic"])
    if r.random() < 0.3:
        t["sample"] = r.choice(["hold", "linear"])
    if r.random() < 0.3:
        t["region"] = {"min": [0] * d, "max": [1.5] * d}
    return t


def turning(r, d):
    t = {"axis": [0.0] * (d - 1) + [2.0], "rate": 4.95}
    for key, value in {"ramp": 0.5, "centrifugal": True, "coriolis": False, "euler": True}.items():
        if r.random() < 0.3:
            t[key] = value
    if d == 3 and r.random() < 0.5:
        t["direction"] = [0, 1, 0]
    return t


def options(r, s, names):
    optional = {
        "title": r.choice(["a title", Plain("2024"), Plain("true")]), "frame": r.choice(["inertial", {"rotating": turning(r, s.get("dimension", 2))}]),
        "transport": r.choice(["auto", "shm", "zmq", "mpi"]), "ledger": {"tolerance": 1e-8, "on-violation": Plain("off"),
                                                                           "energy": {"every": 0, "tolerance": 0.5}},
        "checkpoint": {"interval": r.choice([0, 10]), "windows": 5, "keep": 3}, "on-death": r.choice(["stop", "restart"]),
        "output": {"interval": 0.1, "series": 0.01, "coarsen": 4}, "timeouts": {"connect": 5, "silence": 0.5}}
    for key, value in optional.items():
        if r.random() < 0.3:
            s[key] = value
    if r.random() < 0.3:
        s["time"]["window"] = r.choice(["auto", 0.01])
    if r.random() < 0.3:
        s["time"]["pace"] = r.choice(names)
    if s.get("transport") in ("auto", "zmq", None) and r.random() < 0.2:
        s["address"] = r.choice(["ipc", "tcp://127.0.0.1:5000", "tcp://127.255.0.9:65000"])
    pairs = [(c["from"], c["to"], c["data"]) for c in s.get("couplings", []) if c.get("lag")]
    if pairs and r.random() < 0.4:
        a, b, data = r.choice(pairs)
        s["implicit"] = [{"participants": [a, b], "tolerance": r.choice([1e-5, {data: 1e-3}])}]
        for key, value in {"method": r.choice(["constant", "aitken", "iqn-ils"]), "relaxation": 0.5, "history": 0,
                           "max_iterations": 7}.items():
            if r.random() < 0.5:
                s["implicit"][0][key] = value


def hosts(r, s):
    local = r.random() < 0.4
    for i, p in enumerate(s["participants"].values()):
        p["host"] = r.choice(["localhost", "127.0.0.1"]) if local else f"10.0.0.{i}"
    s["port"] = r.choice([1024, 5000, Plain("6e3")])
    s.pop("address", None)
    s["transport"] = r.choice(["auto", "zmq"])
    if not local or r.random() < 0.5:
        s["security"] = r.choice(["insecure", {"keys": "my/keys"}])
    if r.random() < 0.3:
        s["remote"] = r.choice(["ssh", ["ssh", "-o", "BatchMode=yes"]])


# Values of all types and of doubtful ones; a change puts any of them anywhere.
VALUES = [0, 1, -1, 2, 3, 0.5, -0.25, 1.0, 1e9, 7000, 65536, 300, "", "1", "0.5", "true", "auto", "ipc", "dem", "lineer",
          "kinematics", "grains", "water", "localhost", "10.0.0.9", "10.0.0.9 x", "-x", "a b", "zmq", "restart", "stop",
          "tcp://127.0.0.1:80", "tcp://127.0.0.1:5000", "tcp://10.0.0.1:5000", "tcp://127.0.0.256:5000", "hold", "off",
          Plain("off"), Plain("1e-3"), Plain("012"), Plain("0x1F"), Plain("0o17"), Plain(".nan"), Plain(".inf"),
          Plain("1e-5x"), Plain("True"), Plain("no"), Plain("~"), Plain("+5"), Plain("+-5"), Plain(".5"), Plain("5."),
          True, False, None, [], [0], [0, 1], [0, 0, 1], ["a", "b"], [0, "x"], [None], ["grains", "water"],
          ["grains", "grains"], {}, {"keys": "k"}, {"unit": "m"}, {"load": 0.1}, {"load": 2}, {"a": {"solver": "s"}},
          {"series": {"solver": "s"}}, {"a b": {"solver": "s"}}, {"kinematics": {"columns": {"v": {"unit": "m"}}}},
          {"x": {"columns": {}}}, [{}], [{"from": "grains", "to": "water", "data": "load", "lag": 1}], "insecure",
          "insecre", "W/m^2/K", "m/", "mm", "furlong", "m//s", "1/", "kg m2 s-2", "aitken", "constant", "x" * 65]
KEYS = ["end", "lag", "host", "port", "window", "pace", "predict", "security", "remote", "address", "solver", "command",
        "transport", "windows", "interval", "meshless", "gravity", "unit", "lagg", "Time", "foo", "on-death", "region",
        "dimension", "on-violation", "data", "method", "tolerance", "keys", "frame", "rotating", "direction", "ramp"]


def places(value, path=()):
    """Every place in a value but solvers' own blocks, as paths."""
    if isinstance(value, dict):
        for key, child in value.items():
            yield path + (key,)
            if key != "config":
                yield from places(child, path + (key,))
    elif isinstance(value, list):
        for i, child in enumerate(value):
            yield path + (i,)
            yield from places(child, path + (i,))


def parent(s, path):
    for step in path[:-1]:
        s = s[step]
    return s


def change(r, s):
    """Another value, one key less, one more, one renamed; in one random place."""
    path = r.choice(list(places(s)))
    inside = parent(s, path)
    kind = r.choice(["value", "value", "value", "remove", "add", "rename"])
    if kind == "value":
        inside[path[-1]] = copy.deepcopy(r.choice(VALUES))
    elif kind == "remove":
        del inside[path[-1]]
    elif isinstance(inside, dict):
        key = r.choice(KEYS)
        inside[key] = copy.deepcopy(r.choice(VALUES)) if kind == "add" else inside.pop(path[-1])


def relate(r, s):
    """Breaks a relation between values that are all good by themselves."""
    couplings, names = s.get("couplings", []), list(s["participants"])
    if s.get("dimension") == 3 and isinstance(s.get("frame"), dict):
        s["frame"]["rotating"]["direction"] = [0, 0, 0]
    if couplings and ("implicit" not in s or r.random() < 0.5):
        c = r.choice(couplings)
        r.choice([lambda: c.update(to=c["from"]), lambda: c.update(to="watr"), lambda: couplings.append(dict(c)),
                  lambda: c.update(data="load", region={"min": [0, 0], "max": [1, 1]}),
                  lambda: c.update(data="phase", region={"min": [0, 0], "max": [1, 0]}),
                  lambda: [e.pop("lag", 0) and e.pop("predict", 0) for e in couplings]])()
    if "implicit" in s:
        group = s["implicit"][0]
        r.choice([lambda: group.update(tolerance={"torque": 0.1}), lambda: s["implicit"].append(dict(group)),
                  lambda: group.update(participants=names)])()
    if r.random() < 0.3:
        s["time"]["window"] = 3
    if "port" in s:
        s["port"] = 65535
    if len(names) > 1 and "security" in s and "host" in s["participants"][names[0]]:
        del s["participants"][names[0]]["host"]


def draw(r):
    s = scene(r)
    if r.random() < 0.1:
        relate(r, s)
    for _ in range(r.choice([0, 1, 1, 1, 2, 3])):
        change(r, s)
        if not s:
            break
    return "\n".join(f"{json.dumps(k)}: {written(v)}" for k, v in s.items()) + "\n"


def is_beyond(mistake):
    return not re.search(UNIQUE, mistake) and any(re.search(p, mistake, re.I) for p in BEYOND.values())


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("sluice")
    options.add_argument("verdicts")
    options.add_argument("--scenes", type=int, default=1000)
    options.add_argument("--seed", type=int, default=1)
    o = options.parse_args()
    schema = json.loads(subprocess.run([o.sluice, "schema"], check=True, capture_output=True).stdout)
    jsonschema.Draft7Validator.check_schema(schema)
    judge = jsonschema.Draft7Validator(schema)
    r = random.Random(o.seed)
    texts = [draw(r) for _ in range(o.scenes)]
    told = subprocess.run([o.verdicts], check=True, text=True, capture_output=True,
                          input="".join(text + "\x1e\n" for text in texts)).stdout.split("\n")[:-1]
    assert len(told) == len(texts), f"{len(told)} verdicts on {len(texts)} scenes"
    tally, beyond, disagreements = collections.Counter(), collections.Counter(), []
    for text, line in zip(texts, told):
        mistakes = line.split("\t") if line else []
        wanted = all(is_beyond(m) or re.search(WRITTEN, m, re.I) for m in mistakes)
        if wanted and any(re.search(WRITTEN, m, re.I) for m in mistakes):
            tally["about how a number is written"] += 1
            continue
        tally["good" if not mistakes else "beyond the schema" if wanted else "refused by both"] += 1
        if mistakes and wanted:
            beyond.update(name for name, p in BEYOND.items() for m in mistakes if re.search(p, m, re.I))
        if judge.is_valid(yaml.load(text, Core)) != wanted:
            disagreements.append((text, mistakes))
    for text, mistakes in disagreements[:5]:
        said = [f"{list(e.absolute_path)}: {e.message[:200]}" for e in judge.iter_errors(yaml.load(text, Core))]
        print(f"--- validator: {mistakes or 'good'}\n    schema: {said or 'good'}\n{text}")
    print(f"{len(texts)} scenes: {dict(tally)}, {len(disagreements)} disagreements; beyond: {dict(beyond)}")
    enough = all(tally[kind] >= len(texts) // 50 for kind in ("good", "beyond the schema", "refused by both"))
    never = [name for name in BEYOND if not beyond[name]] if len(texts) >= 10000 else []
    if never:
        print(f"never drawn: {never}")
    return 0 if not disagreements and enough and not never else 1


if __name__ == "__main__":
    sys.exit(main())
