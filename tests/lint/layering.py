"""The diagram of who may include whom, as a test: greps every #include and fails on any other arrow.

    participants -> participants/{files, frame, motion, ranks}; participants -> coupler/coupler.hpp -> {scene, schedule, wire, transport, mapping, record} -> base
"""
import pathlib
import re
import sys

SIBLINGS = {"scene", "schedule", "wire", "transport", "mapping", "record"}
SOLVERS = {"dem", "lbm", "mpm"}
SHARED = {"files", "frame", "motion", "ranks"}  # by the solvers
ADAPTERS = {"liggghts": "dem"}  # to somebody else's solver: reads what ours of that kind reads


def module(path):
    """The layer a repository-relative path belongs to."""
    parts = path.split("/")
    if parts[0] == "coupler":
        return parts[1] if len(parts) > 2 else "composition"
    if parts[0] == "participants":
        return parts[1]
    return parts[0]


def allowed(source, target):
    here, there = module(source), module(target)
    name = pathlib.PurePath(source).name
    if here == there:
        return True
    if there == "base":
        return True
    if here == "base":
        return False
    if here in SIBLINGS:
        return False
    if here == "composition":
        return there in SIBLINGS
    if here in ("cli", "bindings"):
        return there in SIBLINGS | {"composition"}
    if here in ADAPTERS and there == ADAPTERS[here]:
        return name in ("coupling.cpp", "engine.cpp") or not pathlib.PurePath(target).name.startswith(
            ("coupling", "recorder"))
    if here in SOLVERS or here in ADAPTERS:
        if there == "ranks" and name in ("coupling.cpp", "engine.cpp"):
            return True
        if name == "main.cpp":
            return target == "coupler/coupler.hpp"
        if name in ("coupling.cpp", "coupling.hpp"):
            return target == "coupler/coupler.hpp" or there in ("mapping", "record")
        if name in ("recorder.cpp", "recorder.hpp"):
            return there in ("scene", "record")
        return there == "scene" or (there in SHARED and not pathlib.PurePath(target).name.startswith("mpi_"))
    if here in SHARED:
        return there == "scene"
    return here in ("tests", "examples") and there not in ("tests",)


def violations(sources):
    """(path, line, target) of every include that goes against the diagram, from (path, text) pairs."""
    found = []
    for path, text in sources:
        for number, line in enumerate(text.splitlines(), 1):
            match = re.match(r'\s*#include\s+"([^"]+)"', line)
            if not match:
                continue
            target = match.group(1)
            if "/" not in target or not allowed(path, target):
                found.append((path, number, target))
    return found


def main():
    root = pathlib.Path(sys.argv[1])
    sources = [(str(f.relative_to(root)), f.read_text())
               for top in ("coupler", "participants", "tests", "examples")
               for f in sorted((root / top).rglob("*")) if f.suffix in (".c", ".cpp", ".h", ".hpp")]
    # The test can fail: these arrows are forbidden.
    for path, target in (("participants/dem/step.cpp", "participants/lbm/state.hpp"),
                         ("participants/dem/step.cpp", "coupler/coupler.hpp"),
                         ("participants/dem/step.cpp", "participants/ranks/mpi_peers.hpp"),
                         ("participants/dem/step.cpp", "participants/liggghts/engine.hpp"),
                         ("participants/lbm/step.cpp", "participants/liggghts/engine.hpp"),
                         ("participants/liggghts/script.cpp", "participants/lbm/config.hpp"),
                         ("participants/liggghts/script.cpp", "participants/dem/recorder.hpp"),
                         ("participants/liggghts/script.cpp", "coupler/coupler.hpp"),
                         ("participants/frame/rotating_frame.cpp", "participants/dem/state.hpp"),
                         ("coupler/wire/message.cpp", "coupler/scene/scene.hpp"),
                         ("coupler/mapping/rbf.cpp", "coupler/record/table.hpp"),
                         ("participants/dem/step.cpp", "coupler/mapping/mapping.hpp"),
                         ("coupler/base/error.hpp", "coupler/scene/scene.hpp"),
                         ("coupler/scene/scene.cpp", "coupler/coupler.hpp"),
                         ("coupler/cli/main.cpp", "tests/support/toys.hpp"),
                         ("coupler/bindings/sluice_c.cpp", "coupler/cli/commands.hpp")):
        assert violations([(path, f'#include "{target}"')]), (path, target)
    bad = violations(sources)
    for path, number, target in bad:
        print(f"{path}:{number}: includes {target}, which its layer may not know")
    print(f"{len(sources)} files, {len(bad)} forbidden includes")
    return 1 if bad or len(sources) < 50 else 0


if __name__ == "__main__":
    sys.exit(main())
