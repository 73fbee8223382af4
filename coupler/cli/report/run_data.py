"""A run directory as the report sees it. What is missing becomes a sentence in `Run.missing`, never an exception."""

import csv
import json
import math
import os

import numpy

GRAINS, FLUID, CONTINUUM = ("dem", "liggghts"), ("lbm",), ("mpm",)
KNOWN = GRAINS + FLUID + CONTINUUM


class Archive:
    """One participant's HDF5 file: `/steps/NNNNNN` with the attribute `time`."""

    def __init__(self, path):
        import h5py

        self.file = h5py.File(path, "r")
        self.steps = [self.file["steps"][name] for name in sorted(self.file["steps"])]
        self.times = numpy.array([float(step.attrs["time"]) for step in self.steps])
        if not self.steps:
            raise KeyError("it holds no step")

    def nearest(self, time):
        return self.steps[int(numpy.argmin(abs(self.times - time)))]

    def has(self, name):
        return all(name in step for step in self.steps)


class Run:
    """Everything the pages need of one run. SI units."""

    def __init__(self, folder):
        self.folder = folder
        self.missing = []
        self.summary = self._read_summary()
        self.series = self._read_series()
        self.scene = self._read_text("scene.yaml", "the scene's text cannot be shown")
        self.participants = [p for p in self.summary.get("participants", []) if isinstance(p, dict)]
        self.grains_name, self.grains = self._open(GRAINS + CONTINUUM, "position")
        solvers = {p.get("name"): os.path.basename(str(p.get("solver"))) for p in self.participants}
        self.matter = "continuum" if solvers.get(self.grains_name) in CONTINUUM else "grains"
        self.bed = None  # a continuum beside the grains
        if self.grains and self.matter == "grains" and set(solvers.values()) & set(CONTINUUM):
            _, self.bed = self._open(CONTINUUM, "position")
            self.matter = "grains and continuum" if self.bed else "grains"
        self.fluid_name, self.fluid = self._open(FLUID, "spacing")
        self.title = self.summary.get("title") or os.path.basename(os.path.abspath(folder))
        self.gravity = float(numpy.linalg.norm(self.summary.get("gravity") or [9.81]))
        self.height0 = self._fact("H0 [m]", "height")
        self.length0 = self._fact("L0 [m]", "run_out")
        self.time_scale = self._time_scale()

    # -- files ---------------------------------------------------------------------------------------------------------

    def path(self, name):
        return os.path.join(self.folder, name)

    def _read_text(self, name, consequence):
        try:
            with open(self.path(name), encoding="utf-8", errors="replace") as file:
                return file.read()
        except OSError as error:
            self.missing.append(f"{name}: {error.strerror or error}; {consequence}.")
            return ""

    def _read_summary(self):
        text = self._read_text("summary.json", "times, versions and warnings are unknown")
        try:
            summary = json.loads(text) if text else {}
        except ValueError as error:
            self.missing.append(f"summary.json is not valid JSON ({error}); times, versions and warnings are unknown.")
            return {}
        return summary if isinstance(summary, dict) else {}

    def _read_series(self):
        """{header: column}; an empty or unreadable cell is NaN."""
        text = self._read_text("series.csv", "curves cannot be drawn")
        rows = [row for row in csv.reader(text.splitlines()) if row]
        if len(rows) < 2:
            if text:
                self.missing.append("series.csv has no rows; curves cannot be drawn.")
            return {}
        table = numpy.full((len(rows) - 1, len(rows[0])), math.nan)
        for i, row in enumerate(rows[1:]):
            for k, cell in enumerate(row[: len(rows[0])]):
                try:
                    table[i, k] = float(cell)
                except ValueError:
                    pass
        return {header: table[:, k] for k, header in enumerate(rows[0])}

    def _open(self, solvers, mark):
        """(name, Archive) of the first participant with such a solver, else of the first archive with the mark."""
        names = [p.get("name", "") for solver in solvers for p in self.participants
                 if os.path.basename(str(p.get("solver"))) == solver]
        for name in names or self._marked(mark):
            try:
                return name, Archive(self.path(name + ".h5"))
            except ImportError:
                self.missing.append("h5py is not installed (Debian package python3-h5py); pictures cannot be drawn.")
            except (OSError, KeyError) as error:
                exists = os.path.exists(self.path(name + ".h5"))
                reason = f"cannot be read ({error})" if exists else "does not exist"
                self.missing.append(f"{name}.h5 {reason}; pictures of {name} cannot be drawn.")
            return name, None
        return None, None

    def _marked(self, mark):
        """Archives of solvers that we do not know by name: points have positions, lattices a spacing."""
        known = {p.get("name") for p in self.participants if os.path.basename(str(p.get("solver"))) in KNOWN}
        found = []
        for name in sorted(f[:-3] for f in os.listdir(self.folder) if f.endswith(".h5")):
            try:
                archive = Archive(self.path(name + ".h5"))
                if name not in known and (archive.has("position") if mark == "position" else mark in archive.file.attrs):
                    found.append(name)
            except (ImportError, OSError, KeyError):
                pass
        return found

    # -- values --------------------------------------------------------------------------------------------------------

    def _fact(self, name, column):
        """A fact that the grains stated, else the column's first value, else None."""
        for p in self.participants:
            value = (p.get("facts") or {}).get(name)
            if isinstance(value, (int, float)) and value > 0:
                return float(value)
        time, values = self.column(column)
        return float(values[0]) if len(values) and values[0] > 0 else None

    def _time_scale(self):
        """tau_c = sqrt(H0/g) [s], or None."""
        if self.height0 and self.gravity > 0:
            return math.sqrt(self.height0 / self.gravity)
        self.missing.append("H0 or gravity is unknown; times are in seconds, not in tau_c = sqrt(H0/g).")
        return None

    def column(self, quantity, participant=None):
        """(time, values) of `participant.quantity [unit]` without empty cells; two empty arrays when there is none."""
        participant = participant or self.grains_name
        for header, values in self.series.items():
            if header.split(" [")[0] == f"{participant}.{quantity}":
                known = numpy.isfinite(values) & numpy.isfinite(self.series.get("time [s]", values * math.nan))
                return self.series["time [s]"][known] if known.any() else numpy.array([]), values[known]
        return numpy.array([]), numpy.array([])

    def quantities(self, prefix, participant=None):
        """Names of the participant's columns that start with `prefix`, in file order."""
        start = f"{participant or self.grains_name}."
        names = [header.split(" [")[0][len(start):] for header in self.series if header.startswith(start)]
        return [name for name in names if name.startswith(prefix)]

    def scaled(self, time):
        """Times on the plots' axis."""
        return numpy.asarray(time) / self.time_scale if self.time_scale else numpy.asarray(time)

    @property
    def shown(self):
        """The archive whose steps the pictures follow, or None."""
        return self.grains or self.fluid

    @property
    def upward(self):
        """The name of the pictures' vertical axis."""
        return "z" if self.summary.get("dimension") == 3 else "y"

    def clock(self, time):
        if self.time_scale:
            return f"t = {time / self.time_scale:.2f} τ$_c$  ({time:.3g} s)"
        return f"t = {time:.3g} s"

    @property
    def time_label(self):
        return r"time  $t/\tau_c$  [–]" if self.time_scale else "time  $t$  [s]"
