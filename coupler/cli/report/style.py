"""Colours and matplotlib settings: light, printable, readable by the colour-blind (Okabe and Ito's palette)."""

import base64
import io

import matplotlib
import numpy

matplotlib.use("Agg")
import matplotlib.pyplot as pyplot  # noqa: E402
from PIL import Image  # noqa: E402  (matplotlib needs it too)
from matplotlib.colors import LinearSegmentedColormap  # noqa: E402

MAX_BYTES = 500_000  # of one picture: three fit a page of 2 MB as text
PALETTE = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#5A5A5A", "#B8A800"]
LINES = ["-", "--", "-.", ":", (0, (6, 2, 1, 2, 1, 2)), (0, (3, 1)), (0, (1, 1)), (0, (8, 2))]
COMPUTE, WAIT, EXCHANGE = "#0072B2", "#D9D9D9", "#E69F00"
#: blue water below warm grains: the two scales differ in hue and in lightness
WATER = LinearSegmentedColormap.from_list("water", ["#F7FBFF", "#C6DBEF", "#6BAED6", "#2171B5", "#08306B"])
SAND = LinearSegmentedColormap.from_list("sand", ["#F3E6C8", "#FDBE6F", "#F1701F", "#B52A00", "#5E0F00"])
SPIN = "RdBu_r"

pyplot.rcParams.update({
    "font.family": "DejaVu Sans", "font.size": 9.5, "axes.titlesize": 10, "axes.labelsize": 9.5,
    "axes.titleweight": "normal", "axes.spines.top": False, "axes.spines.right": False,
    "axes.edgecolor": "#444444", "axes.linewidth": 0.8,
    "axes.grid": True, "grid.color": "#E4E4E4", "grid.linewidth": 0.7, "axes.axisbelow": True,
    "lines.linewidth": 1.8, "legend.frameon": False, "legend.fontsize": 8.5, "figure.facecolor": "white",
    "svg.hashsalt": "sluice", "svg.fonttype": "path", "xtick.color": "#444444", "ytick.color": "#444444",
})


def as_svg(figure):
    """The figure as the bytes of an SVG file; the same data give the same bytes."""
    return _saved(figure, format="svg", metadata={"Date": None})


def as_png(figure, dots_per_inch=120):
    """The figure as a PNG of 256 colours, dithered: a third of the bytes, and no difference that can be seen. A picture
    that is still too large for the page gets fewer dots."""
    while True:
        data = _reduced(_saved(figure, close=False, format="png", dpi=dots_per_inch,
                               bbox_inches="tight", pad_inches=0.08))
        if len(data) <= MAX_BYTES or dots_per_inch < 60:
            pyplot.close(figure)
            return data
        dots_per_inch *= 0.8


def _reduced(png):
    image = Image.open(io.BytesIO(png)).convert("RGB")
    palette = image.quantize(256, method=Image.Quantize.MEDIANCUT)
    colours = palette.getpalette()
    lightest = max(range(len(colours) // 3), key=lambda i: sum(colours[3 * i:3 * i + 3]))
    colours[3 * lightest:3 * lightest + 3] = (255, 255, 255)
    palette.putpalette(colours)
    pixels = numpy.array(image.quantize(palette=palette, dither=Image.Dither.FLOYDSTEINBERG))
    pixels[(numpy.asarray(image) == 255).all(axis=2)] = lightest  # paper stays paper: Pillow's search is not exact
    reduced = Image.fromarray(pixels, "P")
    reduced.putpalette(colours)
    buffer = io.BytesIO()
    reduced.save(buffer, "PNG", optimize=True)
    return buffer.getvalue()


def _saved(figure, close=True, **options):
    buffer = io.BytesIO()
    figure.savefig(buffer, **options)
    if close:
        pyplot.close(figure)
    return buffer.getvalue()


def data_uri(data):
    kind = "png" if data.startswith(b"\x89PNG") else "svg+xml"
    return f"data:image/{kind};base64,{base64.b64encode(data).decode()}"
