"""Draws the maps of the fluid's stability: plot_stability.py MAP.csv PICTURE.png.

    SLUICE_STABILITY_CSV=MAP.csv ./dev verify stability
"""
import csv
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

COLOURS = {"stable": "#4c9a6a", "refused": "#9aa5b1", "blown up": "#c8553d", "not a number": "#000000"}


def read(path):
    """{sweep: (parameter, measure, {(series, value): row})}, in the file's order."""
    sweeps = {}
    with open(path, newline="") as file:
        for row in csv.DictReader(file):
            sweep = sweeps.setdefault(row["sweep"], (row["parameter"], row["measure"], {}))
            sweep[2][row["series"], float(row["value"])] = row
    return sweeps


def draw(axes, name, sweep):
    parameter, measure, rows = sweep
    series = list(dict.fromkeys(s for s, _ in rows))
    values = list(dict.fromkeys(v for _, v in rows))
    for (s, v), row in rows.items():
        x, y = values.index(v), series.index(s)
        axes.add_patch(plt.Rectangle((x, y), 0.96, 0.9, color=COLOURS[row["outcome"]]))
        if row["outcome"] == "stable":
            axes.text(x + 0.48, y + 0.45, f"{float(row['measured']):.2g}", ha="center", va="center", fontsize=6, color="white")
    axes.set_xlim(0, len(values))
    axes.set_ylim(len(series), 0)
    axes.set_xticks([k + 0.48 for k in range(len(values))], [f"{v:g}" for v in values], fontsize=7)
    axes.set_yticks([k + 0.45 for k in range(len(series))], series, fontsize=7)
    axes.set_xlabel(parameter, fontsize=8)
    axes.set_title(f"{name}: {measure} where stable", fontsize=9)
    axes.tick_params(length=0)
    axes.spines[:].set_visible(False)


def main():
    sweeps = read(sys.argv[1])
    heights = [1 + 0.22 * len({s for s, _ in sweep[2]}) for sweep in sweeps.values()]
    figure, axes = plt.subplots(len(sweeps), 1, figsize=(7, sum(heights)), gridspec_kw={"height_ratios": heights})
    for one, (name, sweep) in zip(axes, sweeps.items()):
        draw(one, name, sweep)
    figure.legend(handles=[plt.Rectangle((0, 0), 1, 1, color=c, label=k) for k, c in list(COLOURS.items())[:3]],
                  loc="upper right", fontsize=7, frameon=False, ncol=3)
    figure.tight_layout(rect=(0, 0, 1, 0.99))
    figure.savefig(sys.argv[2], dpi=110)


if __name__ == "__main__":
    main()
