#!/usr/bin/python3
"""One self-contained HTML page about a run, or a comparison of several.

    /usr/bin/python3 report.py RUN_DIR [OTHER_RUN_DIR ...] --out report.html

Reads summary.json, series.csv, scene.yaml and the participants' HDF5 archives; what is missing is named on the page.
Also writes RUN_DIR/picture.png. Exit: 0 written, 2 usage, 7 the page cannot be written or a Python package is missing.
"""

import argparse
import os
import sys
import traceback

sys.dont_write_bytecode = True  # the folder may be installed read-only, or be a source tree

try:
    import numpy

    import curves
    import page
    import snapshots
    import style
    from run_data import Run
except ImportError as error:
    if error.name in ("curves", "page", "snapshots", "style", "run_data"):
        raise
    print(f"report: the Python package {error.name} is missing (needs numpy, h5py, matplotlib). Try: apt-get install "
          "python3-numpy python3-h5py python3-matplotlib", file=sys.stderr)
    sys.exit(7)


def number(value, digits=3):
    return f"{value:.{digits}g}" if isinstance(value, (int, float)) else "–"


def seconds(value):
    if not isinstance(value, (int, float)):
        return "–"
    if value < 120:
        return f"{value:.3g} s"
    return f"{value / 60:.1f} min" if value < 7200 else f"{value / 3600:.1f} h"


def size(value):
    if not isinstance(value, (int, float)):
        return "–"
    for unit in ("B", "kB", "MB", "GB"):
        if value < 1000 or unit == "GB":
            return f"{value:.3g} {unit}"
        value /= 1000


def guarded(run, what, make):
    """make(), or a sentence in run.missing: an odd file must cost one picture, not the page."""
    try:
        return make()
    except Exception as error:
        if os.environ.get("SLUICE_REPORT_DEBUG"):
            traceback.print_exc()
        run.missing.append(f"{what} could not be drawn ({type(error).__name__}: {error}).")
        return None


def last(curve, run):
    values = curve(run)[1]
    return float(values[-1]) if len(values) else None


# -- one run -----------------------------------------------------------------------------------------------------------


def heading(run):
    summary = run.summary
    code = summary.get("exit")
    badge = ("" if code is None else "<span class=\"badge good\">completed</span> " if code == 0 else
             f"<span class=\"badge bad\">stopped, exit {page.escape(str(code))}</span> ")
    words = [summary.get("scene"), f"{summary['dimension']}D" if "dimension" in summary else None,
             f"transport {summary['transport']}" if summary.get("transport") else None]
    line = page.escape(" · ".join(w for w in words if w))
    why = page.notes([summary["message"]]) if code and summary.get("message") else ""
    return f"<h1>{page.escape(run.title)}</h1>\n<p class=\"soft\">{badge}{line}</p>{why}"


def key_facts(run):
    summary = run.summary
    out, top = last(curves.run_out, run), last(curves.height, run)
    pairs = [
        ("final run-out (L − L₀)/L₀", number(out) if out is not None else ""),
        ("final height H/H₀", number(top) if top is not None else ""),
        ("time scale τc = √(H₀/g)", seconds(run.time_scale) if run.time_scale else ""),
        ("simulated", seconds(summary["end_time"]) if "end_time" in summary else ""),
        ("windows", f"{summary['windows']:,} of {number(summary.get('window_seconds'))} s"
         if "windows" in summary else ""),
        ("took", seconds(summary["wall_seconds"]) if "wall_seconds" in summary else ""),
    ]
    rows = [(p.get("name", "?"), p.get("solver", "?"), name, number(v, 5) if isinstance(v, float) else str(v))
            for p in run.participants for name, v in (p.get("facts") or {}).items()]
    return page.section("facts", "In short", page.facts(pairs),
                        page.table(["participant", "solver", "fact", "#value"], rows))


def svg(run, what, make):
    """The SVG of the figure that make() draws; None when there is nothing to draw, or when that fails."""
    def draw():
        figure = make()
        return style.as_svg(figure) if figure else None

    return guarded(run, what, draw)


def time_section(run):
    rows = []
    for p in run.participants:
        share = curves.shares(p)
        cells = [seconds(p.get(f"{kind}_seconds")) + (f"  ({100 * share[i]:.1f} %)" if share else "")
                 for i, kind in enumerate(("compute", "wait", "exchange"))]
        rows.append([p.get("name", "?"), p.get("solver", "?"), *cells, size(p.get("bytes_sent")),
                     p.get("windows", "–")])
    figure = svg(run, "The shares of time", lambda: curves.time_figure(run))
    trace = " trace.json beside this page shows the windows one by one (open it in Perfetto)."
    return page.section(
        "time", "Where the time went",
        page.picture(figure, "Bars: share of compute, wait and exchange per participant",
                     "Wait: blocked until the other side's data came. Exchange: packing, sending, receiving."
                     + trace * os.path.exists(run.path("trace.json")),
                     "Not known: summary.json holds no times."),
        page.table(["participant", "solver", "#compute", "#wait", "#exchange", "#sent", "#windows"], rows))


def work_section(run):
    """What the ledger says of the work that loads do: from every process of every participant."""
    rows = []
    for p in (r for p in run.participants for r in [p, *(p.get("ranks") or [])]):
        for entry in p.get("ledger") or []:
            e = entry.get("energy") or {}
            moved, made = e.get("moved [J]") or 0.0, e.get("made [J]") or 0.0
            if moved > 0:
                rows.append([entry.get("edge", "?"), p.get("name", "?"), e.get("windows", "–"),
                             number(e.get("given [J]") or 0.0, 4), number(e.get("taken [J]") or 0.0, 4),
                             f"{100 * made / moved:.2g} %"])
    return page.section(
        "work", "Work across the coupling",
        page.table(["edge", "participant", "#windows looked at", "#given [J]", "#taken [J]", "#made, of the work moved"],
                   rows))


def curve_sections(run):
    kinematics = svg(run, "Run-out and height", lambda: curves.kinematics_figure([run]))
    kinetic = svg(run, "Kinetic energy", lambda: curves.kinetic_figure([run]))
    ledger, closing = guarded(run, "The energy ledger", lambda: curves.ledger_figure(run)) or (None, "")
    ledger = svg(run, "The energy ledger", lambda: ledger)
    return [
        page.section("run-out", "Run-out and height", page.picture(
            kinematics, "Run-out and height of the column against time",
            otherwise="series.csv has no run_out or height, or L0 and H0 are unknown.")),
        page.section("energy", "Energy", page.picture(
            kinetic, "Kinetic energy against time", otherwise="series.csv has no kinetic energy."), page.picture(
            ledger, "Where the released potential energy is, stacked, against time",
            "Where the released potential energy is. " + closing,
            "series.csv has no energy ledger (potential, elastic, dissipated_...).")),
    ]


def snapshot_sections(run):
    if not run.shown:
        return [page.section("snapshots", "Snapshots",
                             page.paragraph("There is no archive of grains or fluid to draw.", "soft"))]
    caption = ("Speed of the fluid." if not run.grains else "Grains true to scale, coloured by speed, over the fluid's "
               "speed." if run.fluid else "Grains true to scale, coloured by speed.")
    figure = guarded(run, "Snapshots", lambda: style.as_png(snapshots.snapshot_figure(run)))
    sections = [page.section("snapshots", "Snapshots", page.picture(
        figure, "The run at several times, coloured by speed", caption + " One scale for all panels."))]
    if run.fluid and run.fluid.has("vorticity"):
        spin = guarded(run, "Vorticity", lambda: style.as_png(snapshots.snapshot_figure(run, vorticity=True)))
        sections.append(page.section("vorticity", "Vorticity", page.picture(
            spin, "Vorticity of the fluid at several times, grains in grey",
            "Vorticity of the fluid. Red turns counter-clockwise, blue clockwise.")))
    elif run.fluid:
        run.missing.append(f"{run.fluid_name}.h5 holds no vorticity; it is not shown.")
    return sections


def skipped_section(run):
    rows = [(p.get("name", "?"), s.get("what", ""), s.get("why", ""),
             f"{100 * s['share']:.0f} %" if isinstance(s.get("share"), (int, float)) else "–")
            for p in run.participants for s in (p.get("skipped") or [])]
    return page.section("skipped", "What was skipped, and why",
                        page.table(["participant", "skipped", "because", "#share of the work"], rows) or
                        page.paragraph("Nothing was reported as skipped.", "soft"))


def warning_section(run):
    texts = [str(w) for w in run.summary.get("warnings") or []]
    texts += [f"{p.get('name', '?')}: {w}" for p in run.participants for w in (p.get("warnings") or [])]
    texts += [f"{p.get('name', '?')} stopped with exit {p['exit']}." for p in run.participants if p.get("exit")]
    texts += [f"{p.get('name', '?')} left no summary: it was killed, or never began." for p in run.participants
              if p.get("exit", 0) is None]
    return page.section("warnings", "Warnings", page.notes(dict.fromkeys(texts)) or page.paragraph("None.", "soft"))


def versions_section(run):
    rows = [(label, run.summary[key]) for key, label in (("version", "sluice"), ("scene_hash", "scene hash"),
                                                         ("transport", "transport")) if run.summary.get(key)]
    rows += [("this page", f"numpy {numpy.__version__}, matplotlib {style.matplotlib.__version__}, "
                           f"Python {sys.version.split()[0]}")]
    return page.section("versions", "Versions", page.table(["what", "version"], rows))


def missing_section(runs):
    texts = [f"{run.title}: {text}" if len(runs) > 1 else text for run in runs for text in run.missing]
    return page.section("missing", "Not on this page", page.notes(dict.fromkeys(texts)))


def write_picture(run):
    """RUN_DIR/picture.png: the busiest moment."""
    if not run.shown:
        return
    data = guarded(run, "picture.png", lambda: style.as_png(snapshots.picture(run), dots_per_inch=140))
    if data:
        write(run.path("picture.png"), data)


def run_page(run):
    write_picture(run)
    sections = [heading(run), key_facts(run), *snapshot_sections(run), *curve_sections(run), work_section(run), time_section(run),
                skipped_section(run), warning_section(run),
                page.section("scene", "Scene", page.folded(run.summary.get("scene") or "scene.yaml", run.scene)),
                versions_section(run)]
    return page.document(run.title, sections + [missing_section([run])])


# -- several runs ------------------------------------------------------------------------------------------------------


def comparison_table(runs):
    rows = []
    for run in runs:
        energy = curves.kinetic(run)[1]
        rows.append([run.title, number(last(curves.run_out, run)), number(last(curves.height, run)),
                     number(float(energy.max())) if len(energy) else "–", seconds(run.time_scale),
                     seconds(run.summary.get("wall_seconds"))])
    return page.table(["run", "#final run-out", "#final height H/H₀", "#largest kinetic energy [J/m]", "#τc", "#took"],
                      rows)


def comparison_page(runs):
    for run in runs:
        write_picture(run)
    first = runs[0]
    kinematics = svg(first, "Run-out and height", lambda: curves.kinematics_figure(runs))
    kinetic = svg(first, "Kinetic energy", lambda: curves.kinetic_figure(runs))
    final = None
    if any(run.shown for run in runs):
        final = guarded(first, "The last snapshots", lambda: style.as_png(snapshots.last_figure(runs)))
    title = f"Comparison of {len(runs)} runs"
    return page.document(title, [
        f"<h1>{title}</h1>",
        page.paragraph(" · ".join(run.title for run in runs), "soft"),
        page.section("facts", "In short", comparison_table(runs)),
        page.section("run-out", "Run-out and height", page.picture(
            kinematics, "Run-out and height of all runs against time", "Each run in its own τc = √(H₀/g).",
            "No run has run_out or height in its series.csv.")),
        page.section("energy", "Kinetic energy", page.picture(
            kinetic, "Kinetic energy of all runs against time", otherwise="No run has it in its series.csv.")),
        page.section("snapshots", "At the end", page.picture(
            final, "Last snapshots of all runs", "The last snapshots in the same window, on the same scales of speed.",
            "No run has an archive to draw.")),
        page.section("scene", "Scenes", *[page.folded(run.title, run.scene) for run in runs]),
        page.section("versions", "Versions", page.table(
            ["run", "sluice", "scene hash"],
            [(r.title, r.summary.get("version", "–"), r.summary.get("scene_hash", "–")) for r in runs])),
        missing_section(runs),
    ])


# -- command -----------------------------------------------------------------------------------------------------------


def write(path, data):
    """Aside, then renamed."""
    aside = path + ".partial"
    try:
        with open(aside, "wb") as file:
            file.write(data)
        os.replace(aside, path)
    except OSError as error:
        print(f"report: {path}: {error.strerror or error}. Choose another --out, or free some space.", file=sys.stderr)
        sys.exit(7)


def main(arguments=None):
    parser = argparse.ArgumentParser(prog="report", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("runs", metavar="RUN_DIR", nargs="+")
    parser.add_argument("--out", default="report.html")
    options = parser.parse_args(arguments)
    for folder in options.runs:
        if not os.path.isdir(folder):
            parser.error(f"{folder} is not a folder (needs a run's directory, as `sluice run --out` leaves it).")
    runs = [Run(folder) for folder in options.runs]
    text = run_page(runs[0]) if len(runs) == 1 else comparison_page(runs)
    write(options.out, text.encode())
    print(f"{options.out}: {len(text) / 1000:.0f} kB")
    return 0


if __name__ == "__main__":
    sys.exit(main())
