#!/usr/bin/python3
"""Reads a run directory back with readers that are not ours and compares it with its archives.

    readback.py RUN_DIR [--reader own|vtk] [--expect sample] [--settled DENSITY GRAVITY]

Checks every step of every .pvd: the files exist and open, times increase, counts and array lengths fit, values are
finite; where `<name>.h5` lies beside `<name>.pvd`, its steps' times, counts and arrays must agree. The contacts of
`<name>.forces.pvd` must be those of `<name>.measures.h5`, between the grains of `<name>.h5`; with --settled they must
carry the weight of every grain. `vtk` uses VTK's XML
readers (package python3-vtk9), `own` a parser of 40 lines below. Exit: 0 good, 1 wrong, 77 the reader is not installed.
"""

import argparse
import math
import os
import re
import sys
import xml.etree.ElementTree as ElementTree

import numpy

TYPES = {"Float32": "<f4", "Float64": "<f8", "Int64": "<i8"}
problems = []


def check(ok, message):
    if not ok:
        problems.append(message)


def read_own(path):
    """One .vtp or .vti -> {count, arrays, points, extent, origin, spacing}; strict on purpose."""
    raw = open(path, "rb").read()
    head, rest = raw.split(b'<AppendedData encoding="raw">\n_', 1)
    root = ElementTree.fromstring(head + b"</VTKFile>")
    check(root.get("byte_order") == "LittleEndian" and root.get("header_type") == "UInt64", f"{path}: header")
    used = 0

    def values(node):
        nonlocal used
        offset = int(node.get("offset"))
        size = int(numpy.frombuffer(rest, "<u8", 1, offset)[0])
        used = max(used, offset + 8 + size)
        flat = numpy.frombuffer(rest, TYPES[node.get("type")], size // int(TYPES[node.get("type")][-1]), offset + 8)
        components = int(node.get("NumberOfComponents"))
        return flat.reshape(-1, components) if components > 1 else flat

    piece = root.find(".//Piece")
    data = root.find(".//PointData") if root.get("type") == "PolyData" else root.find(".//CellData")
    result = {"arrays": {node.get("Name"): values(node) for node in data}}
    if root.get("type") == "PolyData":
        result["count"] = int(piece.get("NumberOfPoints"))
        result["points"] = values(root.find(".//Points/DataArray"))
        result["lines"] = int(piece.get("NumberOfLines"))
        each = 2 if root.find(".//Lines") is not None else 1
        connectivity, offsets = [values(node) for node in root.find(".//Lines" if each == 2 else ".//Verts")]
        check(int(piece.get("NumberOfLines" if each == 2 else "NumberOfVerts")) * each == result["count"], f"{path}: cells")
        check(list(connectivity) == list(range(result["count"])), f"{path}: connectivity")
        check(list(offsets) == list(range(each, result["count"] + 1, each)), f"{path}: offsets")
    else:
        image = root.find("ImageData")
        extent = [int(v) for v in image.get("WholeExtent").split()]
        result["cells"] = [b - a for a, b in zip(extent[::2], extent[1::2])]
        result["count"] = math.prod(max(1, n) for n in result["cells"])
        result["origin"] = [float(v) for v in image.get("Origin").split()]
        result["spacing"] = [float(v) for v in image.get("Spacing").split()]
    check(rest[used:] == b"\n</AppendedData>\n</VTKFile>\n", f"{path}: the appended data ends early or late")
    return result


def read_vtk(path):
    """The same through VTK's own readers."""
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOXML import vtkXMLImageDataReader, vtkXMLPolyDataReader

    polydata = path.endswith(".vtp")
    reader = vtkXMLPolyDataReader() if polydata else vtkXMLImageDataReader()
    errors = []
    reader.AddObserver("ErrorEvent", lambda *_: errors.append("ErrorEvent"))
    reader.AddObserver("WarningEvent", lambda *_: errors.append("WarningEvent"))
    reader.SetFileName(path)
    reader.Update()
    check(not errors and reader.GetErrorCode() == 0, f"{path}: VTK's reader complains: {errors}")
    output = reader.GetOutput()
    data = output.GetPointData() if polydata else output.GetCellData()
    arrays = {}
    for i in range(data.GetNumberOfArrays()):
        array = data.GetArray(i)
        arrays[array.GetName()] = vtk_to_numpy(array)
    result = {"arrays": arrays}
    if polydata:
        result["count"] = output.GetNumberOfPoints()
        result["lines"] = output.GetNumberOfLines()
        check(output.GetNumberOfVerts() + 2 * result["lines"] == result["count"], f"{path}: vertices and lines")
        points = output.GetPoints()
        result["points"] = vtk_to_numpy(points.GetData()) if points and result["count"] else numpy.zeros((0, 3))
    else:
        extent = output.GetExtent()
        result["cells"] = [b - a for a, b in zip(extent[::2], extent[1::2])]
        result["count"] = output.GetNumberOfCells()
        result["origin"], result["spacing"] = list(output.GetOrigin()), list(output.GetSpacing())
    return result


def read_collection(path):
    """[(time, part, file)] of a .pvd"""
    entries = []
    for node in ElementTree.parse(path).getroot().iter("DataSet"):
        entries.append((float(node.get("timestep")), int(node.get("part")), node.get("file")))
    return entries


def check_frame(path, frame):
    for name, values in frame["arrays"].items():
        check(len(values) == frame["count"], f"{path}: {name} has {len(values)} tuples, not {frame['count']}")
        check(numpy.isfinite(values).all(), f"{path}: {name} is not finite")
    if "points" in frame:
        check(frame["points"].shape == (frame["count"], 3), f"{path}: points have shape {frame['points'].shape}")
        check(numpy.isfinite(frame["points"]).all(), f"{path}: points are not finite")


def same(path, name, shown, stored):
    """An array of a picture file against the archive's dataset of that name: 2D vectors carry z = 0."""
    stored = numpy.asarray(stored)
    if shown.ndim == 2:
        stored = stored.reshape(-1, stored.shape[-1])
        check((shown[:, stored.shape[1]:] == 0).all(), f"{path}: {name}: z is not 0")
        shown = shown[:, : stored.shape[1]]
    else:
        stored = stored.reshape(-1)
    check(shown.shape == stored.shape, f"{path}: {name}: shape {shown.shape}, archive {stored.shape}")
    if shown.shape == stored.shape:
        check((shown == stored.astype(shown.dtype)).all(), f"{path}: {name} differs from the archive")


def compare_with_archive(path, frame, time, step):
    check(float(step.attrs["time"]) == time, f"{path}: time {time}, archive {step.attrs['time']}")
    shared = 0
    if "points" in frame and "position" in step:
        check(len(step["position"]) == frame["count"], f"{path}: N {frame['count']}, archive {len(step['position'])}")
        same(path, "position", frame["points"], step["position"])
        shared += 1
    for name, values in frame["arrays"].items():
        if name in step:
            same(path, name, values, step[name])
            shared += 1
    check(shared > 0, f"{path}: no array in common with the archive ({', '.join(step)})")


def check_collection(folder, name, read):
    path = os.path.join(folder, name)
    entries = read_collection(path)
    for part in sorted({part for _, part, _ in entries}):
        times = [time for time, p, _ in entries if p == part]
        check(all(a < b for a, b in zip(times, times[1:])), f"{path}: times of part {part} do not increase")
    archive_path = path[:-4] + ".h5"
    archive = None
    if os.path.exists(archive_path):
        import h5py

        archive = h5py.File(archive_path, "r")
        check(len(archive["steps"]) == len(entries),
              f"{path}: {len(entries)} frames, {len(archive['steps'])} steps in the archive")
    counts = []
    for time, _, file in entries:
        full = os.path.join(folder, file)
        frame = read(full)
        check_frame(full, frame)
        counts.append(frame["count"])
        step = re.search(r"_(\d+)\.vt[pi]$", file).group(1)
        if archive is not None and step in archive["steps"]:
            compare_with_archive(full, frame, time, archive["steps"][step])
    against = "compared with its archive" if archive is not None else "no archive of that name"
    extremes = f"{min(counts, default=0)} to {max(counts, default=0)}"
    print(f"{name}: {len(entries)} files, {extremes} points or cells, {against}")


def check_contacts(folder, name, read, settled):
    """Frames of <name>.forces.pvd against the steps of <name>.measures.h5 and, where one has the time, <name>.h5."""
    import h5py

    measures = h5py.File(f"{folder}/{name}.measures.h5", "r")["steps"]
    steps = {float(s.attrs["time"]): s for s in measures.values() if "contact_ids" in s}
    grains = {float(s.attrs["time"]): s for s in h5py.File(f"{folder}/{name}.h5", "r")["steps"].values()}
    entries = read_collection(f"{folder}/{name}.forces.pvd")
    check(len(entries) == len(steps), f"{name}.forces: {len(entries)} frames, {len(steps)} steps with contacts")
    for time, _, file in entries:
        frame, step = read(os.path.join(folder, file)), steps[time]
        ids, force = step["contact_ids"][()], step["contact_force"][()]
        check(frame["lines"] == len(ids), f"{file}: {frame['lines']} lines, {len(ids)} contacts")
        check((frame["arrays"]["id"].reshape(-1, 2) == ids).all(), f"{file}: ids")
        normal, tangential = frame["arrays"]["normal_force"], frame["arrays"]["tangential_force"]
        check((normal[::2] == normal[1::2]).all() and (normal >= 0).all(), f"{file}: normal_force of both ends")
        wanted = numpy.linalg.norm(force, axis=1)  # the two parts are at right angles; the file is float32
        check(numpy.allclose(numpy.hypot(normal, tangential)[::2], wanted, rtol=1e-5, atol=1e-5 * wanted.max(initial=0)),
              f"{file}: forces differ from the archive")
        if time in grains:
            check_ends(file, frame, ids, grains[time])
    if settled:
        time = max(set(steps) & set(grains))
        check_weights(name, steps[time], grains[time], *settled)
    print(f"{name}.forces.pvd: {len(entries)} frames of contacts, compared with {name}.measures.h5")


def check_ends(file, frame, ids, grains):
    """Ends with the id of a grain lie at its centre; a wall's end no further than the grain's radius."""
    place = dict(zip(grains["id"][()], grains["position"][()]))
    radius = dict(zip(grains["id"][()], grains["radius"][()]))
    ends = frame["points"].reshape(-1, 2, 3)
    for (first, second), (a, b) in zip(ids, ends):
        size = len(place[first])
        check(numpy.allclose(a[:size], place[first], atol=1e-6), f"{file}: an end is not at grain {first}")
        if second >= 0:
            check(numpy.allclose(b[:size], place[second], atol=1e-6), f"{file}: an end is not at grain {second}")
        else:
            check(numpy.linalg.norm(b - a) <= radius[first] * (1 + 1e-5), f"{file}: a wall beyond grain {first}")


def check_weights(name, step, grains, density, gravity):
    """Contacts carry the weight of each grain to 1 % of the mean weight, and walls the sum to 1e-3."""
    ids, force = step["contact_ids"][()], step["contact_force"][()]
    radius, size = grains["radius"][()], force.shape[1]
    weight = density * gravity * (math.pi * radius**2 if size == 2 else 4 / 3 * math.pi * radius**3)
    index = {grain: k for k, grain in enumerate(grains["id"][()])}
    carried, walls = numpy.zeros((len(radius), size)), 0
    for (first, second), f in zip(ids, force):
        carried[index[first]] += f
        if second >= 0:
            carried[index[second]] -= f
        else:
            walls += f[-1]
    check(abs(walls / weight.sum() - 1) < 1e-3, f"{name}: walls carry {walls} N of {weight.sum()} N")
    carried[:, -1] -= weight
    worst = numpy.linalg.norm(carried, axis=1).max() / weight.mean()
    check(worst < 1e-2, f"{name}: the forces on a grain leave {worst} of a mean weight")
    print(f"{name}: walls carry {walls / weight.sum():.6f} of the weight, at worst {worst:.2g} of a grain's is left")


def expect_sample(folder, read):
    """The values that sample.cpp wrote, from their formulas."""
    for k in range(4):
        for series, kind in (("grains", "f8"), ("grains_single", "f4")):
            frame = read(f"{folder}/{series}/{series}_{k:06}.vtp")
            i = numpy.arange(5 * k)
            columns = {"velocity": (-k + 0 * i, i / 8, 0 * i), "angular_velocity": -i, "radius": 1 + i, "id": 10 * k + i}
            check(sorted(frame["arrays"]) == sorted(columns), f"{series}: arrays {sorted(frame['arrays'])}")
            for name, values in columns.items():
                wanted = numpy.array(values).T.reshape(frame["arrays"][name].shape)
                check((frame["arrays"][name] == wanted).all(), f"{series} {k}: {name}")
                check(name == "id" or frame["arrays"][name].dtype == kind, f"{series} {k}: {name} has the wrong type")
            check((frame["points"] == numpy.array((i, k / 4 + 0 * i, 0 * i)).T).all(), f"{series} {k}: position")
        frame = read(f"{folder}/water/water_{k:06}.vti")
        x, y = numpy.meshgrid(numpy.arange(7), numpy.arange(4))
        check(frame["cells"] == [7, 4, 0] and frame["count"] == 28, f"water: cells {frame['cells']}")
        check(frame["origin"] == [-1, 0.5, 0] and frame["spacing"] == [0.5, 0.25, 1], "water: origin or spacing")
        check((frame["arrays"]["pressure"] == (x + 7 * y + k).reshape(-1)).all(), f"water {k}: pressure")
        wanted = numpy.array((x + k, y, 0 * x)).reshape(3, -1).T
        check((frame["arrays"]["velocity"] == wanted).all(), f"water {k}: velocity")
    entries = read_collection(f"{folder}/all.pvd")
    check([part for _, part, _ in entries] == [0, 1] * 4, "all.pvd: parts")
    check([time for time, _, _ in entries] == [t for k in range(4) for t in [0.1 * k] * 2], "all.pvd: times")
    expect_sample_archive(folder)


def expect_sample_archive(folder):
    import h5py

    with h5py.File(f"{folder}/archive.h5", "r") as joint:
        check(joint["grains/steps/000002/position"].attrs["unit"] == b"m", "archive.h5: unit of position")
        check(joint["grains"].attrs["scene_hash"] == b"0123abcd", "archive.h5: scene hash")
        water = joint["water/steps/000001/velocity"]
        check(water.shape == (4, 7, 2) and water.compression == "gzip" and water.shuffle, "archive.h5: velocity of water")
        check(list(joint["water"].attrs["origin"]) == [-1, 0.5], "archive.h5: origin")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", metavar="RUN_DIR")
    parser.add_argument("--reader", choices=("own", "vtk"), help="default: vtk where installed, else own")
    parser.add_argument("--expect", choices=("sample",))
    parser.add_argument("--settled", nargs=2, type=float, metavar=("DENSITY", "GRAVITY"),
                        help="kg/m3, m/s2: the forces of contacts carry the weights at the last time")
    options = parser.parse_args()
    try:
        import vtkmodules.vtkIOXML  # noqa: F401
        has_vtk = True
    except ImportError as error:
        has_vtk = False
        if options.reader == "vtk":
            print(f"skipped: VTK's readers are not installed ({error}; package python3-vtk9)")
            return 77
    read = read_own if options.reader == "own" or not has_vtk else read_vtk
    collections = sorted(name for name in os.listdir(options.folder) if name.endswith(".pvd"))
    check(collections, f"{options.folder}: no .pvd")
    for name in collections:
        check_collection(options.folder, name, read)
        if name.endswith(".forces.pvd"):
            check_contacts(options.folder, name[: -len(".forces.pvd")], read, options.settled)
    if options.expect == "sample":
        expect_sample(options.folder, read)
    for problem in problems[:20]:
        print("WRONG:", problem)
    print(f"{read.__name__}: {len(collections)} collections, {len(problems)} problems")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
