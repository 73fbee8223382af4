"""Curves against time: run-out, height, kinetic energy, the energy ledger, shares of wall time."""

import numpy

from style import COMPUTE, EXCHANGE, LINES, PALETTE, WAIT, pyplot

MAX_POINTS = 800  # per curve: more cannot be seen and makes the page large
MAX_LEDGER_POINTS = 250  # per area of the ledger: each has two edges

LEDGER = {
    "kinetic": "moving", "rotational": "spinning",
    "dissipated_normal": "lost in impacts (normal)", "dissipated_tangential": "lost in impacts (tangential)",
    "dissipated_sliding": "lost in sliding", "dissipated_rolling": "lost in rolling",
    "vanished": "gone with contacts that open",
}


def thinned(time, values, most=MAX_POINTS):
    stride = max(1, -(-len(time) // most))
    return time[::stride], values[::stride]


def run_out(run):
    """t, (L - L0)/L0"""
    time, front = run.column("run_out")
    return (time, front / run.length0 - 1.0) if run.length0 else (time[:0], front[:0])


def height(run):
    """t, H/H0"""
    time, top = run.column("height")
    return (time, top / run.height0) if run.height0 else (time[:0], top[:0])


def kinetic(run):
    return run.column("kinetic")


def _axis_label(runs):
    same = len({bool(run.time_scale) for run in runs}) == 1
    return runs[0].time_label if same else "time  (t/τc, or s where unknown)"


def _draw(axes, runs, curve, label):
    """One line per run that has the data; returns how many."""
    drawn = 0
    for i, run in enumerate(runs):
        time, values = curve(run)
        if len(time) < 2:
            continue
        axes.plot(*thinned(run.scaled(time), values), color=PALETTE[i % 8], linestyle=LINES[i % 8], label=run.title)
        drawn += 1
    axes.set_xlabel(_axis_label(runs))
    axes.set_ylabel(label)
    axes.margins(x=0.01)
    if not drawn:
        axes.text(0.5, 0.5, "no data", transform=axes.transAxes, ha="center", color="#888888")
    return drawn


def kinematics_figure(runs):
    """Run-out and height of all runs, side by side; None without data."""
    figure, axes = pyplot.subplots(1, 2, figsize=(9.2, 3.3), layout="constrained")
    drawn = _draw(axes[0], runs, run_out, r"run-out  $(L-L_0)/L_0$  [–]")
    drawn += _draw(axes[1], runs, height, r"height  $H/H_0$  [–]")
    axes[1].set_ylim(0, max(1.05, 1.05 * axes[1].dataLim.y1) if axes[1].lines else None)
    if len(runs) > 1 and drawn:
        for place in axes:
            if place.get_legend_handles_labels()[0]:
                place.legend()
    return _kept(figure, drawn)


def kinetic_figure(runs):
    """Kinetic energy of the grains of all runs, and of the fluid (dotted) when there is one run; None without data."""
    figure, axes = pyplot.subplots(figsize=(9.2, 3.1), layout="constrained")
    drawn = _draw(axes, runs, kinetic, "kinetic energy  [J/m]")
    if len(runs) == 1 and drawn:
        axes.lines[0].set_label("grains, moving")
        for name, label in (("rotational", "grains, spinning"), ("fluid", "fluid")):
            time, values = runs[0].column(name) if name != "fluid" else runs[0].column("kinetic", runs[0].fluid_name)
            if len(time) > 1:
                line = len(axes.lines)
                axes.plot(*thinned(runs[0].scaled(time), values), color=PALETTE[line], linestyle=LINES[line],
                          label=label)
    axes.set_ylim(bottom=0)
    axes.ticklabel_format(axis="y", scilimits=(-2, 3), useMathText=True)
    if drawn:
        axes.legend()
    return _kept(figure, drawn)


def ledger(run):
    """(time, released, [(label, energy)]) [s, J/m]: potential and elastic energy released, and where it is; or None."""
    time, potential = run.column("potential")
    names = [n for n in run.quantities("") if n in LEDGER or n.startswith("dissipated_")]
    if len(time) < 2 or not names:
        return None

    def since_start(name):
        t, values = run.column(name)
        return numpy.interp(time, t, values - values[0]) if len(t) else 0 * time

    released = potential[0] - potential - sum(since_start(name) for name in run.quantities("elastic"))
    parts = [(LEDGER.get(name, name.replace("_", " ")), since_start(name)) for name in names]
    if run.quantities("fluid_work"):  # done by the fluid on the grains: what is negative went to the fluid
        parts.append(("given to the fluid", -since_start("fluid_work")))
    return time, released, parts


def ledger_figure(run):
    """(figure, sentence about how well the ledger closes), or (None, "")."""
    booked = ledger(run)
    if booked is None:
        return None, ""
    time, released, parts = booked
    figure, axes = pyplot.subplots(figsize=(9.2, 3.7), layout="constrained")
    stack = [thinned(time, numpy.maximum(values, 0.0), MAX_LEDGER_POINTS)[1] for _, values in parts]
    line = thinned(time, released, MAX_LEDGER_POINTS)
    x = run.scaled(line[0])
    axes.stackplot(x, stack, labels=[label for label, _ in parts], colors=PALETTE, alpha=0.85, edgecolor="white",
                   linewidth=0.4)
    axes.plot(x, line[1], color="black", linewidth=1.6, label="released (potential, elastic)")
    axes.set_xlabel(run.time_label)
    axes.set_ylabel("energy since the start  [J/m]")
    axes.margins(x=0.01)
    axes.ticklabel_format(axis="y", scilimits=(-2, 3), useMathText=True)
    handles, labels = axes.get_legend_handles_labels()
    axes.legend(handles[::-1], labels[::-1], loc="center left", bbox_to_anchor=(1.01, 0.5))
    scale = abs(released).max()
    error = abs(released - sum(values for _, values in parts)).max()
    closing = f"The ledger closes to {100 * error / scale:.2g} % of the released energy." if scale > 0 else ""
    return figure, closing


def shares(participant):
    """Seconds of compute, wait, exchange, other fractions sum to 1; None without times."""
    seconds = [float(participant.get(f"{kind}_seconds") or 0.0) for kind in ("compute", "wait", "exchange")]
    return [s / sum(seconds) for s in seconds] if sum(seconds) > 0 else None


def time_figure(run):
    """Horizontal bars of compute / wait / exchange per participant; None without times."""
    rows = [(p.get("name", "?"), shares(p)) for p in run.participants if shares(p)]
    if not rows:
        return None
    figure, axes = pyplot.subplots(figsize=(9.2, 0.75 + 0.42 * len(rows)), layout="constrained")
    left = numpy.zeros(len(rows))
    for kind, colour, ink in ((0, COMPUTE, "white"), (1, WAIT, "black"), (2, EXCHANGE, "black")):
        widths = numpy.array([100 * share[kind] for _, share in rows])
        axes.barh([name for name, _ in rows], widths, left=left, color=colour, height=0.62,
                  label=("compute", "wait", "exchange")[kind])
        for y, (start, width) in enumerate(zip(left, widths)):
            if width > 6:
                axes.text(start + width / 2, y, f"{width:.0f} %", ha="center", va="center", color=ink, fontsize=8.5)
        left += widths
    axes.invert_yaxis()
    axes.set_xlim(0, 100)
    axes.set_xlabel("share of the participant's time  [%]")
    axes.grid(False)
    axes.legend(loc="lower left", bbox_to_anchor=(0, 1.0), ncol=3)
    return figure


def _kept(figure, drawn):
    if drawn:
        return figure
    pyplot.close(figure)
    return None
