"""check.py RUN REFERENCE: the sphere of RUN, moved by another code, is where our DEM has it in REFERENCE.

Both are of second order in free fall; the other code samples the load at the ends of its steps instead of in the middle. Mark: 1e-4 of the
diameter, the load's change over a step of 2e-5 s, for 0.1 s.
"""
import csv
import json
import pathlib
import sys

run, reference = map(pathlib.Path, sys.argv[1:])
facts = json.loads((run / "summary.json").read_text())["participants"]
height = next(p["facts"]["height at the end [m]"] for p in facts if p["name"] == "sphere")
with open(reference / "sphere.csv") as rows:
    ours = [float(row["centre_z [m]"]) for row in csv.DictReader(rows)]
difference = abs(height - ours[-1]) / 0.015
print(f"height {height:.9f} m, our DEM {ours[-1]:.9f} m: {difference:.1e} of the diameter; fallen {0.1275 - height:.4f} m")
assert 0.1275 - height > 3e-3, "it has not fallen"
assert difference < 1e-4, difference
