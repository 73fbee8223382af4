"""check.py RUN: what the fluid gave in each window is what the disc took in the next one; drag points against the pull;
the lattice lost what the disc took.
"""
import csv
import math
import pathlib
import sys


def read(file):
    with open(file) as rows:
        return [{name: float(value or "nan") for name, value in row.items()} for row in csv.DictReader(rows)]


run = pathlib.Path(sys.argv[1])
disc, water = read(run / "disc.csv"), read(run / "water.csv")
assert len(disc) == 300 and len(water) == 301, (len(disc), len(water))  # the fluid has a row for t = 0
inner = 1000 / 2000  # fluid that the lattice carries along inside of the disc, over the disc's mass
for axis, pull in (("x", 0.05), ("y", 0.02)):  # N/m
    taken = [row[f"impulse_{axis} [N s/m]"] for row in disc]
    given = [row[f"window_impulse_{axis} [N s/m]"] for row in water[1:]]
    own = [0] + [row[f"momentum_{axis} [N s/m]"] for row in disc]
    fluid = [row[f"momentum_{axis} [N s/m]"] for row in water]

    # third law: the same number is divided and multiplied by the window's length once more, a rounding each
    assert taken[0] == 0  # lag 1: nothing was given before the first window
    largest = max(map(abs, given))
    third = max(abs(t - g) for t, g in zip(taken[1:], given)) / largest
    assert third <= 4.5e-16, (axis, third)

    # Drag and added mass both point against the pull, once the fluid inside has followed the sudden start (two steps).
    assert all(g < 0 for g in given[2:]) and own[-1] > 0, axis
    assert own[-1] < pull * 0.03, axis  # what it would have without the fluid

    # participants/lbm/README.md: a load is the mean of two steps' exchanges, which the lattice lost, and the inertia of
    # the fluid inside, whose velocity is the disc's in the middle of a step. Mark: C08, momentum a step, 1e-12.
    middle = [(a + b) / 2 for a, b in zip(own, own[1:])]
    worst = 0
    for n in range(2, len(given)):
        exchange = (fluid[n - 1] - fluid[n + 1]) / 2
        worst = max(worst, abs(given[n] - exchange - inner * (middle[n] - middle[n - 1])))
    print(f"{axis}: third law off by {third:.1e} of the largest impulse, momentum by {worst / fluid[-1]:.1e}; the disc has "
          f"{own[-1] / (pull * 0.03):.3f} of what it would have without the fluid")
    assert worst <= 1e-12 * fluid[-1], (axis, worst)
