"""Fails unless the grains of a shortened run lie in the funnel, above the gate, with all their energy accounted for."""
import csv
import pathlib
import sys

rows = list(csv.DictReader((pathlib.Path(sys.argv[1]) / "grains.csv").open()))
balance = [float(row["balance [J]"]) for row in rows]
height = [float(row["centre_z [m]"]) for row in rows]
assert len(rows) > 10
assert all(abs(b / balance[0] - 1) < 1e-5 for b in balance), balance
assert height[-1] < height[0] - 0.04 and height[-1] > 0.04, height  # they have fallen from 0.107 m; the gate is at 0.03 m
