"""Writes hopper.stl (a square funnel under a shaft, in mm), gate.stl and grains.csv: what hopper.yaml reads.

    python3 hopper.py
"""
import pathlib
import random

SHAFT, OPENING, TOP, KINK, OUTLET = 60.0, 24.0, 160.0, 60.0, 30.0  # mm: half as wide from the axis; heights
HERE = pathlib.Path(__file__).resolve().parent


def square(half, height):
    """Corners of a square about the axis, anticlockwise from above."""
    return [(-half, -half, height), (half, -half, height), (half, half, height), (-half, half, height)]


def write_stl(file, name, triangles):
    lines = [f"solid {name}"]
    for corners in triangles:
        lines += [" facet normal 0 0 0", "  outer loop"]  # normals do not matter: both sides are walls
        lines += ["   vertex " + " ".join(f"{x:g}" for x in corner) for corner in corners]
        lines += ["  endloop", " endfacet"]
    (HERE / file).write_text("\n".join(lines + [f"endsolid {name}", ""]))


def between(lower, upper):
    """Two triangles for each side between two squares."""
    sides = [(k, (k + 1) % 4) for k in range(4)]
    return [t for a, b in sides for t in ((lower[a], lower[b], upper[b]), (lower[a], upper[b], upper[a]))]


def main():
    outlet, kink, top = square(OPENING / 2, OUTLET), square(SHAFT / 2, KINK), square(SHAFT / 2, TOP)
    write_stl("hopper.stl", "hopper", between(outlet, kink) + between(kink, top))
    write_stl("gate.stl", "gate", [(outlet[0], outlet[1], outlet[2]), (outlet[0], outlet[2], outlet[3])])
    rng = random.Random(1)
    rows = ["x [m],y [m],z [m],radius [m]"]
    for k in range(360):  # loose above the funnel: layers of 6 x 6, 9 mm apart
        layer, place = divmod(k, 36)
        x, y = (-22.5 + 9 * (place % 6)), (-22.5 + 9 * (place // 6))
        radius = rng.uniform(2.6, 3.4)
        rows.append(",".join(f"{1e-3 * v:.6f}" for v in (x + rng.uniform(-0.8, 0.8), y + rng.uniform(-0.8, 0.8),
                                                         66 + 9 * layer, radius)))
    (HERE / "grains.csv").write_text("\n".join(rows) + "\n")


if __name__ == "__main__":
    main()
