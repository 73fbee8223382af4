"""Pictures of the grains, true to scale, over the fluid. Of 3D runs: the side view (x, z), the fluid's middle plane."""

import numpy
from matplotlib.cm import ScalarMappable
from matplotlib.collections import EllipseCollection
from matplotlib.colors import Normalize

from style import SAND, SPIN, WATER, pyplot

BAR_HEIGHT = 0.65  # of a colour bar with its label [inch]
MAX_CELLS = 900  # across the picture: finer lattices are thinned


class Grains:
    """One step: x, y, radius [m], speed [m/s]"""

    def __init__(self, step):
        position = numpy.asarray(step["position"], dtype=float)
        if position.shape[1] == 3:
            order = numpy.argsort(-position[:, 1])  # far ones first
        else:
            order = numpy.arange(len(position))
        self.x, self.y = position[order, 0], position[order, -1]
        velocity = numpy.asarray(step["velocity"], dtype=float) if "velocity" in step else numpy.zeros_like(position)
        self.speed = numpy.linalg.norm(velocity, axis=1)[order]
        self.radius = self._radius(step, position)[order]
        good = numpy.isfinite(self.x) & numpy.isfinite(self.y) & numpy.isfinite(self.speed)
        self.x, self.y, self.speed, self.radius = (v[good] for v in (self.x, self.y, self.speed, self.radius))

    @staticmethod
    def _radius(step, position):
        if "radius" in step:
            return numpy.asarray(step["radius"], dtype=float)
        if "volume" in step:  # material points: the disc of the same area
            return numpy.sqrt(numpy.asarray(step["volume"], dtype=float) / numpy.pi)
        spread = numpy.ptp(position, axis=0).max() if len(position) else 1.0
        return numpy.full(len(position), 0.4 * spread / max(1.0, numpy.sqrt(len(position))))


def clouds(run, time):
    """What has places at a time: a continuum beside grains, then the grains."""
    return [Grains(archive.nearest(time)) for archive in (run.bed, run.grains) if archive]


class Fluid:
    """One step of a lattice: speed [m/s] and vorticity [1/s], shape [y][x], and the extent of its cells [m]"""

    def __init__(self, archive, step):
        attributes = archive.file.attrs
        origin = numpy.asarray(attributes.get("origin", [0.0, 0.0]), dtype=float)
        spacing = numpy.asarray(attributes.get("spacing", [1.0, 1.0]), dtype=float)
        shape = step["velocity"].shape
        stride = max(1, -(-max(shape[0], shape[-2]) // MAX_CELLS))
        velocity = self._plane(step["velocity"], stride, vector=True)
        self.speed = numpy.linalg.norm(velocity, axis=-1)
        self.vorticity = self._plane(step["vorticity"], stride) if "vorticity" in step else None
        high = origin[-1] + shape[0] * spacing[-1]
        self.extent = (origin[0], origin[0] + shape[-2] * spacing[0], origin[-1], high)
        if "solid_fraction" in step:
            solid = self._plane(step["solid_fraction"], stride) > 0.99
            self.speed = numpy.where(solid, numpy.nan, self.speed)

    @staticmethod
    def _plane(dataset, stride, vector=False):
        if dataset.ndim == 3 + vector:
            return numpy.asarray(dataset[::stride, dataset.shape[1] // 2, ::stride], dtype=float)
        return numpy.asarray(dataset[::stride, ::stride], dtype=float)


def chosen_times(run, count=6):
    """Four to six times: the start, the collapse (in tau_c), the end; evenly spread when tau_c does not fit."""
    times = run.shown.times
    end = times[-1]
    if run.time_scale and end >= 3.5 * run.time_scale:
        wanted = numpy.array([0, 0.75, 1.5, 2.25, 3.0, end / run.time_scale]) * run.time_scale
    else:
        wanted = numpy.linspace(times[0], end, count)
    steps = sorted({int(numpy.argmin(abs(times - t))) for t in wanted})
    return [times[s] for s in steps]


def busiest_time(run):
    """The time at which the grains, or the fluid alone, move most."""
    return max(zip(run.shown.times, run.shown.steps),
               key=lambda pair: float(numpy.mean(numpy.square(pair[1]["velocity"][:]))) if "velocity" in pair[1]
               and len(pair[1]["velocity"]) else 0.0)[0]


def view(run, times):
    """(x0, x1, y0, y1) [m] of the part worth showing, the same for all times."""
    shown = [g for t in times for g in clouds(run, t) if len(g.x)]
    if not shown:
        return Fluid(run.fluid, run.fluid.steps[0]).extent if run.fluid else (0.0, 1.0, 0.0, 1.0)
    x0, x1 = min((g.x - g.radius).min() for g in shown), max((g.x + g.radius).max() for g in shown)
    y0, y1 = min((g.y - g.radius).min() for g in shown), max((g.y + g.radius).max() for g in shown)
    margin = 0.12 * (y1 - y0)
    behind = 2.5 if run.fluid else 0.2  # grains alone stand against something there
    box = [x0 - behind * margin, x1 + 2.5 * margin, y0 - behind * margin, y1 + 2 * margin]
    if run.fluid:
        limits = Fluid(run.fluid, run.fluid.steps[0]).extent
        box = [max(box[0], limits[0]), min(box[1], limits[1]), max(box[2], limits[2]), min(box[3], limits[3])]
        if not (box[1] > box[0] and box[3] > box[2]):  # the grains lie outside the lattice
            box = [x0 - margin, x1 + margin, y0 - margin, y1 + margin]
    return tuple(box)


def discs(axes, grains, **options):
    size = 2 * grains.radius
    collection = EllipseCollection(size, size, numpy.zeros_like(size), units="xy", transOffset=axes.transData,
                                   offsets=numpy.column_stack((grains.x, grains.y)), **options)
    axes.add_collection(collection)
    return collection


class Scales:
    """Colour scales shared by all panels of a figure: robust maxima over the shown steps."""

    def __init__(self, run, times):
        self.grains = self.fluid = self.vorticity = None
        self.matter = run.matter
        if run.grains:
            self.grains = Normalize(0, _top([g.speed for t in times for g in clouds(run, t)], 99.0))
        if run.fluid:
            steps = [Fluid(run.fluid, run.fluid.nearest(t)) for t in times]
            self.fluid = Normalize(0, _top([s.speed for s in steps], 99.7))
            spin = [abs(s.vorticity) for s in steps if s.vorticity is not None]
            top = _top(spin, 98.5) if spin else 1.0
            self.vorticity = Normalize(-top, top)


    def widen(self, other):
        """Makes both scales the larger of the two."""
        for name in ("grains", "fluid"):
            norms = [n for n in (getattr(self, name), getattr(other, name)) if n]
            top = max((n.vmax for n in norms), default=None)
            for n in norms:
                n.vmax = top
        self.grains, self.fluid = self.grains or other.grains, self.fluid or other.fluid

    def bars(self):
        """How many colour bars a picture of speeds needs."""
        return bool(self.grains) + bool(self.fluid)


def _top(arrays, percentile):
    """The largest over the steps of the step's percentile: a few wild cells do not set the scale."""
    finite = [a[numpy.isfinite(a)] for a in arrays]
    top = max((float(numpy.percentile(a, percentile)) for a in finite if a.size), default=0.0)
    return top if top > 0 else 1.0


def panel(axes, run, time, box, scales, vorticity=False):
    """One snapshot: fluid below, grains above."""
    if run.fluid:
        fluid = Fluid(run.fluid, run.fluid.nearest(time))
        field = fluid.vorticity if vorticity else fluid.speed
        axes.imshow(field, origin="lower", extent=fluid.extent, cmap=SPIN if vorticity else WATER,
                    norm=scales.vorticity if vorticity else scales.fluid, interpolation="bilinear", zorder=0)
    for grains in clouds(run, time):
        width = 0.15 if len(grains.x) > 600 else 0.3
        paint = ({"facecolors": "#D8D4CC", "edgecolors": "#55504A"} if vorticity else
                 {"array": grains.speed, "cmap": SAND, "norm": scales.grains, "edgecolors": "#5B4A30"})
        discs(axes, grains, linewidths=width, zorder=2, **paint)
    axes.set_xlim(box[0], box[1])
    axes.set_ylim(box[2], box[3])
    axes.set_aspect("equal")
    axes.grid(False)
    axes.set_title(run.clock(time), loc="left", fontsize=9)
    axes.locator_params(nbins=5)


def colour_bars(figure, axes, scales, vorticity=False, **options):
    bars = []
    if vorticity:
        bars.append((scales.vorticity, SPIN, "vorticity  [1/s]  (> 0: counter-clockwise)", "both"))
    else:
        if scales.grains:
            bars.append((scales.grains, SAND, f"speed of the {scales.matter}  [m/s]", "max"))
        if scales.fluid:
            bars.append((scales.fluid, WATER, "speed of the fluid  [m/s]", "max"))
    for norm, colours, label, extend in bars:
        bar = figure.colorbar(ScalarMappable(norm, colours), ax=axes, extend=extend, **options)
        bar.set_label(label, fontsize=8.5)
        bar.outline.set_linewidth(0.5)


def _panel_size(box, width):
    return width * (box[3] - box[2]) / (box[1] - box[0])


def finish_axes(axes, used, upward):
    """Hides the places that are not used and labels the outer axes of the others."""
    for place in axes.flat[used:]:
        place.set_visible(False)
    for place in axes[:, 0]:
        place.set_ylabel(f"{upward}  [m]")
    for column in axes.T:
        lowest = [place for place in column if place.get_visible()]
        if lowest:
            lowest[-1].set_xlabel("x  [m]")
            lowest[-1].tick_params(labelbottom=True)


def snapshot_figure(run, vorticity=False):
    """Four to six panels on one scale."""
    times = chosen_times(run)
    box, scales = view(run, times), Scales(run, times)
    columns = 2 if box[1] - box[0] > 0.8 * (box[3] - box[2]) else 3
    rows = -(-len(times) // columns)
    high = min(4.5, max(0.9, _panel_size(box, 8.3 / columns))) + 0.42
    bars = 1 if vorticity else scales.bars()
    figure, axes = pyplot.subplots(rows, columns, figsize=(9.2, rows * high + BAR_HEIGHT * bars),
                                   layout="constrained", squeeze=False, sharex=True, sharey=True)
    for place, time in zip(axes.flat, times):
        panel(place, run, time, box, scales, vorticity)
    finish_axes(axes, len(times), run.upward)
    colour_bars(figure, axes, scales, vorticity, location="bottom", shrink=0.45, aspect=35, pad=0.02)
    return figure


def picture(run, time=None, vorticity=False, width=9.2):
    """The single panel for a README: the time at which the grains move most."""
    time = busiest_time(run) if time is None else time
    box, scales = view(run, chosen_times(run)), Scales(run, [time])
    high = min(6.0, max(1.2, _panel_size(box, width - 1.0)))
    bars = 1 if vorticity else scales.bars()
    figure, axes = pyplot.subplots(figsize=(width, high + 0.7 + BAR_HEIGHT * bars), layout="constrained")
    panel(axes, run, time, box, scales, vorticity)
    axes.set_title(f"{run.title}\n{run.clock(time)}", loc="left", fontsize=10)
    axes.set_xlabel("x  [m]")
    axes.set_ylabel(f"{run.upward}  [m]")
    colour_bars(figure, axes, scales, vorticity, location="bottom", shrink=0.45, aspect=35, pad=0.02)
    return figure


def last_figure(runs):
    """The last snapshots of several runs, one below the other, in the same window and on the same scales."""
    runs = [run for run in runs if run.shown]
    boxes = [view(run, [run.shown.times[0], run.shown.times[-1]]) for run in runs]
    box = (min(b[0] for b in boxes), max(b[1] for b in boxes), min(b[2] for b in boxes), max(b[3] for b in boxes))
    scales = Scales(runs[0], chosen_times(runs[0]))
    for run in runs[1:]:
        scales.widen(Scales(run, chosen_times(run)))
    columns = 2 if len(runs) > 1 and box[1] - box[0] < 3.2 * (box[3] - box[2]) else 1
    rows = -(-len(runs) // columns)
    high = min(4.0, max(0.9, _panel_size(box, 8.2 / columns))) + 0.55
    figure, axes = pyplot.subplots(rows, columns, figsize=(9.2, high * rows + BAR_HEIGHT * scales.bars()),
                                   layout="constrained", squeeze=False, sharex=True, sharey=True)
    for place, run in zip(axes.flat, runs):
        panel(place, run, run.shown.times[-1], box, scales)
        place.set_title(f"{run.title}\n{run.clock(run.shown.times[-1])}", loc="left", fontsize=9)
    finish_axes(axes, len(runs), runs[0].upward)
    colour_bars(figure, axes, scales, location="bottom", shrink=0.45, aspect=35, pad=0.02)
    return figure
