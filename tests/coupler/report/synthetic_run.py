"""Writes run directories that look like real ones, to test the report: a column that collapses by a closed form.

    synthetic_run.py FOLDER [--dry] [--title TEXT] [--slow FACTOR]
"""

import argparse
import json
import os

import h5py
import numpy

HEIGHT, LENGTH, GRAVITY, SPACING = 0.04, 0.05, 9.81, 0.0006
TIME_SCALE = (HEIGHT / GRAVITY) ** 0.5
PROGRESS = 2.4  # the collapse is over at about this many time scales


def progress(time, slow):
    """0 before, 1 after the collapse, and its rate [1/s]"""
    s = numpy.clip(time / (PROGRESS * TIME_SCALE * slow), 0, 1)
    return s * s * (3 - 2 * s), 6 * s * (1 - s) / (PROGRESS * TIME_SCALE * slow)


class Column:
    """Discs in a rectangle that deforms into a triangle-like heap; area is kept roughly."""

    def __init__(self, count, seed=3):
        random = numpy.random.default_rng(seed)
        pitch = (HEIGHT * LENGTH / count) ** 0.5
        columns, rows = int(LENGTH / pitch), int(HEIGHT / pitch)
        x, y = numpy.meshgrid((numpy.arange(columns) + 0.5) * pitch, (numpy.arange(rows) + 0.5) * pitch)
        self.x = x.ravel() + random.uniform(-0.12, 0.12, x.size) * pitch
        self.y = y.ravel() + random.uniform(-0.12, 0.12, x.size) * pitch
        self.radius = random.uniform(0.36, 0.52, x.size) * pitch

    def at(self, time, slow):
        p, rate = progress(time, slow)
        stretch = (self.x / LENGTH) ** 2 * (0.4 + 0.6 * self.y / HEIGHT)
        fall = numpy.clip(self.x / LENGTH - 0.2, 0, 1) * 0.75
        position = numpy.column_stack((self.x + 1.1 * LENGTH * p * stretch, self.y * (1 - p * fall)))
        velocity = rate * numpy.column_stack((1.1 * LENGTH * stretch, -self.y * fall))
        return position, velocity


def write_grains(folder, column, times, slow):
    with h5py.File(os.path.join(folder, "grains.h5"), "w") as file:
        for i, time in enumerate(times):
            position, velocity = column.at(time, slow)
            step = file.create_group(f"steps/{i:06}")
            step.attrs["time"] = time
            step["id"] = numpy.arange(len(position))
            step["position"], step["velocity"] = position, velocity
            step["angular_velocity"] = -velocity[:, 0] / column.radius
            step["radius"] = column.radius


def fluid_at(time, slow, x, y):
    """A vortex that rides on the front."""
    p, rate = progress(time, slow)
    centre = (LENGTH * (1 + 0.8 * p), 0.55 * HEIGHT)
    dx, dy = x - centre[0], y - centre[1]
    core = 0.012
    strength = 0.35 * rate * LENGTH * numpy.exp(-(dx**2 + dy**2) / core**2) / core
    return numpy.stack((strength * dy, -strength * dx), axis=-1)


def write_water(folder, times, slow):
    nx, ny = int(0.16 / SPACING), int(0.06 / SPACING)
    x, y = numpy.meshgrid((numpy.arange(nx) + 0.5) * SPACING, (numpy.arange(ny) + 0.5) * SPACING)
    with h5py.File(os.path.join(folder, "water.h5"), "w") as file:
        file.attrs["origin"], file.attrs["spacing"] = [0.0, 0.0], [SPACING, SPACING]
        for i, time in enumerate(times):
            velocity = fluid_at(time, slow, x, y)
            step = file.create_group(f"steps/{i:06}")
            step.attrs["time"] = time
            curl = numpy.gradient(velocity[..., 1], SPACING, axis=1) - numpy.gradient(velocity[..., 0], SPACING, axis=0)
            fields = {"velocity": velocity, "vorticity": curl, "pressure": 0 * x, "solid_fraction": 0 * x}
            for name, values in fields.items():
                step.create_dataset(name, data=values.astype("f4"), compression="gzip", compression_opts=1, shuffle=True)


def write_series(folder, dry, slow, end):
    time = numpy.linspace(0, end, 400)
    p, rate = progress(time, slow)
    released = 0.3 * p
    kinetic = 0.5 * 40 * (0.3 * LENGTH * rate) ** 2 * 0.05
    rest = released - kinetic * 1.1
    to_fluid = 0 if dry else 0.35
    columns = {
        "time [s]": time, "grains.run_out [m]": LENGTH * (1 + 1.1 * p), "grains.height [m]": HEIGHT * (1 - 0.15 * p),
        "grains.kinetic [J/m]": kinetic, "grains.rotational [J/m]": 0.1 * kinetic,
        "grains.potential [J/m]": 1 - released,
        "grains.elastic [J/m]": 0 * time, "grains.dissipated_normal [J/m]": (0.4 - to_fluid / 2) * rest,
        "grains.dissipated_tangential [J/m]": 0.1 * rest,
        "grains.dissipated_sliding [J/m]": (0.5 - to_fluid / 2) * rest, "grains.fluid_work [J/m]": -to_fluid * rest}
    if not dry:
        columns["water.max_speed [m/s]"] = rate * LENGTH
        columns["water.kinetic [J/m]"] = 0.3 * kinetic
    with open(os.path.join(folder, "series.csv"), "w") as file:
        file.write(",".join(columns) + "\n")
        for row in zip(*columns.values()):
            file.write(",".join(repr(float(v)) for v in row) + "\n")


def write_summary(folder, title, dry, end, count):
    grains = {"name": "grains", "solver": "dem", "exit": 0, "windows": 12000, "compute_seconds": 41.2,
              "wait_seconds": 18.3, "exchange_seconds": 0.9, "bytes_sent": 480_000_000,
              "facts": {"H0 [m]": HEIGHT, "L0 [m]": LENGTH, "grains": count}, "warnings": [],
              "skipped": [{"what": "pairs of sleeping grains", "why": "neither moved since the last list", "share": 0.41}]}
    water = {"name": "water", "solver": "lbm", "exit": 0, "windows": 12000, "compute_seconds": 57.9, "wait_seconds": 1.8,
             "exchange_seconds": 1.0, "bytes_sent": 390_000_000, "facts": {"tau": 0.61, "Mach": 0.042, "cells": 26600},
             "warnings": ["tau = 0.61: below 0.55 the lattice may become unstable"],
             "skipped": [{"what": "lattice tiles without fluid", "why": "they lie outside the box", "share": 0.12},
                         {"what": "grain cover in plain tiles", "why": "no grain is near", "share": 0.83}]}
    summary = {"title": title, "scene": "immersed_column.yaml", "dimension": 2, "gravity": [0, -GRAVITY],
               "windows": 12000, "window_seconds": end / 12000, "end_time": end,
               "wall_seconds": 62.4, "exit": 0, "version": "0.1.0",
               "scene_hash": "5d0c0c9e5b7f2a11", "transport": "zmq",
               "participants": [grains] if dry else [grains, water],
               "warnings": ["the fluid's window is 3 times the grains' step"] if not dry else []}
    with open(os.path.join(folder, "summary.json"), "w") as file:
        json.dump(summary, file, indent=1)


def write_run(folder, dry=False, title="Immersed collapse, a = 0.8", slow=1.0, count=1000):
    os.makedirs(folder, exist_ok=True)
    end = 5 * TIME_SCALE
    column = Column(count)
    write_grains(folder, column, numpy.linspace(0, end, 41), slow)
    if not dry:
        write_water(folder, numpy.linspace(0, end, 21), slow)
    write_series(folder, dry, slow, end)
    write_summary(folder, title, dry, end, len(column.x))
    with open(os.path.join(folder, "scene.yaml"), "w") as file:
        file.write(f"sluice: 1\ntitle: {title} # <b>&\ndimension: 2\n")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder")
    parser.add_argument("--dry", action="store_true")
    parser.add_argument("--title", default="Immersed collapse, a = 0.8")
    parser.add_argument("--slow", type=float, default=1.0)
    options = parser.parse_args()
    write_run(options.folder, options.dry, options.title, options.slow)
