"""Draws errors against the time to get them: plot_errors.py TABLE.csv PICTURE.png.

    SLUICE_ERRORS=FOLDER ./dev verify errors    # leaves a table for each solver
"""
import csv
import math
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

STYLES = {"bgk": ("#9aa5b1", "o", "-"), "trt": ("#2f6f9f", "o", "-"), "mrt": ("#c8553d", "s", "-"),
          "central": ("#7b5ea7", "^", "-"), "trt, forced": ("#3a3a3a", "v", "--"),
          "trt, single": ("#2f6f9f", "x", ":"), "trt, interpolated": ("#4c9a6a", "o", "--"),
          "mrt, interpolated": ("#d9a441", "s", "--"),
          "gimp": ("#2f6f9f", "o", "-"), "gimp, width: stretch": ("#2f6f9f", "x", ":"), "spline": ("#c8553d", "s", "-"),
          "cpdi": ("#4c9a6a", "o", "--"), "linear": ("#9aa5b1", "o", "-"),
          "gimp, shared_volume: false": ("#d9a441", "s", "--")}
NUMBERED = "trt", "gimp"  # whose points are labelled with their cells


def read(path):
    """{case: {way: [(cells, error, seconds)]}}, in the file's order; runs that blew up are left out."""
    cases = {}
    with open(path, newline="") as file:
        for row in csv.DictReader(file):
            point = int(row["cells"]), float(row["error"]), float(row["seconds"])
            ways = cases.setdefault(row["case"], {}).setdefault(row["way"], [])
            if math.isfinite(point[1]):
                ways.append(point)
    return cases


def main():
    cases = read(sys.argv[1])
    columns = len(cases) + 1 if len(cases) < 4 else 3  # one for the legend
    rows = math.ceil((len(cases) + 1) / columns)
    figure, axes = plt.subplots(rows, columns, figsize=(4 * columns, 3.5 * rows))
    for one, (name, ways) in zip(axes.flat, cases.items()):
        for way, points in ways.items():
            colour, marker, line = STYLES[way]
            one.loglog([p[2] for p in points], [100 * p[1] for p in points], color=colour, marker=marker, linestyle=line,
                       markersize=4, linewidth=1.2, label=way)
        for cells, error, seconds in [p for way in NUMBERED for p in ways.get(way, [])]:
            one.annotate(str(cells), (seconds, 100 * error), textcoords="offset points", xytext=(4, 4), fontsize=7)
        one.set_title(name + " (numbers: cells)", fontsize=9)
        one.set_xlabel("time of one core [s]", fontsize=8)
        one.set_ylabel("error [%]", fontsize=8)
        one.grid(True, which="both", linewidth=0.3)
        one.tick_params(labelsize=7)
    for unused in axes.flat[len(cases):]:
        unused.axis("off")
    shown = [way for way in STYLES if any(way in ways for ways in cases.values())]
    handles = []
    for way in shown:
        colour, marker, line = STYLES[way]
        handles.append(plt.Line2D([], [], color=colour, marker=marker, linestyle=line, label=way))
    axes.flat[-1].legend(handles=handles, fontsize=9, frameon=False, loc="center")
    figure.tight_layout()
    figure.savefig(sys.argv[2], dpi=110)


if __name__ == "__main__":
    main()
