"""Run-out of dry columns over the aspect ratio, beside experiments and the literature's own simulations.

    python3 sweep.py [--out DIR] [--discs N] [A ...]      A: aspect ratios, default 0.2 to 10

Runs configs/run_out.yaml with `sluice` once for each, prints a table and leaves run_out.svg in DIR (runs/run_out).
"""
import argparse
import json
import math
import pathlib
import subprocess

import matplotlib

matplotlib.use("svg")
from matplotlib import pyplot  # noqa: E402

SCENE = pathlib.Path(__file__).resolve().parents[2] / "configs" / "run_out.yaml"
GRAINS = "participants.grains.config"
# (L - L0)/L0 over a: quasi two-dimensional experiments (Lajeunesse et al. 2005) and discrete elements, as plotted in
# Kumar's thesis (2015, chapter 4), whose grains and frictions the scene has.
EXPERIMENT = {0.2: 0.3, 0.4: 0.63, 0.6: 1.02, 0.8: 1.41, 1: 1.81, 2: 3.469, 4: 6.464, 6: 8.302, 8: 10.295, 10: 11.19}
THESIS = {0.2: 0.25, 0.4: 0.6, 0.6: 1.05, 0.8: 1.399, 1: 1.68, 2: 3.789, 4: 6.768, 6: 8.192, 8: 9.952, 10: 10.989}


def run_out(a, discs, folder):
    """(L - L0)/L0 of one column after 7 sqrt(H0/g)."""
    height = math.sqrt(discs * math.pi * (0.575e-3 ** 2) * 1.02 / 0.82 * a)  # of 0.92 to 1.38 mm at a fraction of 0.82
    words = ["sluice", "run", str(SCENE), "--out", str(folder), "--no-report", "--quiet"]
    for key, value in ((f"{GRAINS}.column.aspect_ratio", a), (f"{GRAINS}.column.count", discs),
                       ("time.end", f"{7 * math.sqrt(height / 9.81):.4g}")):
        words += ["--set", f"{key}={value}"]
    subprocess.run(words, check=True)
    facts = json.loads((folder / "summary.json").read_text())["participants"][0]["facts"]
    return facts["final run-out [m]"] / facts["L0 [m]"] - 1


def plot(ours, discs, file):
    figure, axes = pyplot.subplots(figsize=(6.4, 4.4), layout="constrained")
    axes.loglog(EXPERIMENT.keys(), EXPERIMENT.values(), "ks", markersize=5, label="experiments, Lajeunesse et al. 2005")
    axes.loglog(THESIS.keys(), THESIS.values(), "^", color="#888888", markersize=6, label="discrete elements, Kumar 2015")
    axes.loglog(ours.keys(), ours.values(), "o-", color="#0072b2", markersize=5, label=f"sluice, {discs} discs")
    axes.set(xlabel="aspect ratio $a = H_0 / L_0$", ylabel="run-out $(L - L_0) / L_0$")
    axes.legend()
    axes.grid(True, which="both", linewidth=0.3)
    figure.savefig(file)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("ratios", nargs="*", type=float, default=list(EXPERIMENT), metavar="A")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("runs/run_out"))
    parser.add_argument("--discs", type=int, default=3000)
    options = parser.parse_args()
    ours = {}
    print("     a   sluice  experiment  thesis")
    for a in options.ratios:
        ours[a] = run_out(a, options.discs, options.out / f"a_{a:g}")
        known = [f"{table[a]:10.3g}" if a in table else " " * 10 for table in (EXPERIMENT, THESIS)]
        print(f"{a:6g} {ours[a]:8.3g}" + "".join(known), flush=True)
    plot(ours, options.discs, options.out / "run_out.svg")


if __name__ == "__main__":
    main()
