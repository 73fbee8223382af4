#!/usr/bin/python3
"""Runs report.py on synthetic run directories: whole, dry, several, and with everything that can be missing."""

import contextlib
import io
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from html.parser import HTMLParser
from unittest import mock

sys.dont_write_bytecode = True
try:
    import h5py
    import synthetic_run
except ImportError as error:
    print(f"skipped: {error} (packages python3-numpy, python3-h5py)")
    sys.exit(77)

HERE = os.path.dirname(os.path.abspath(__file__))
REPORT = os.path.join(HERE, "..", "..", "..", "coupler", "cli", "report", "report.py")
sys.path.insert(0, os.path.dirname(REPORT))
try:
    import report
except SystemExit:  # it has said which package is missing
    sys.exit(77)

BLANK = report.style._saved(report.style.pyplot.figure(figsize=(1, 1)), format="png", dpi=10)
SECTIONS = ("facts", "snapshots", "run-out", "energy", "time", "skipped", "warnings", "scene", "versions")


class Page(HTMLParser):
    """The ids of sections, the pictures and the balance of tags."""

    VOID = {"meta", "img", "br", "link", "hr"}

    def __init__(self, text):
        super().__init__()
        self.sections, self.pictures, self.open, self.links = [], [], [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        values = dict(attributes)
        if tag == "section":
            self.sections.append(values["id"])
        if tag == "img":
            self.pictures.append(values)
        self.links += [values[name] for name in ("src", "href", "action", "data") if name in values]
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open and self.open.pop() == tag, f"</{tag}> closes nothing"


class ReportTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp(prefix="report_")
        cls.immersed, cls.dry = os.path.join(cls.folder, "immersed"), os.path.join(cls.folder, "dry")
        synthetic_run.write_run(cls.immersed, count=200)
        synthetic_run.write_run(cls.dry, dry=True, title="Dry collapse", slow=0.8, count=200)

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.folder)

    def report(self, *folders, draw=True):
        """(page, text) of report.py over these folders; checks what every page must be. Drawing takes seconds: without
        `draw` the figures are built, but their pixels are not made."""
        out = os.path.join(self.folder, "report.html")
        blank = mock.patch.object(report.style, "_saved", lambda figure, **_: report.style.pyplot.close(figure) or BLANK)
        with contextlib.redirect_stdout(io.StringIO()), contextlib.nullcontext() if draw else blank:
            self.assertEqual(report.main([*folders, "--out", out]), 0)
        self.assertLess(os.path.getsize(out), 2_000_000)
        with open(out, encoding="utf-8") as file:
            text = file.read()
        page = Page(text)
        self.assertEqual(page.open, [])
        self.assertTrue(all(link.startswith("data:image/") for link in page.links), "a link to the outside")
        self.assertIsNone(re.search(r"(src|href)\s*=\s*[\"']?https?:|url\(|@import|<script", text))
        self.assertTrue(all(picture.get("alt") for picture in page.pictures), "a picture without alt")
        return page, text

    def copy(self, name, source=None):
        target = os.path.join(self.folder, name)
        shutil.copytree(source or self.immersed, target)
        return target

    def test_one_run_has_every_section_and_picture(self):
        page, text = self.report(self.immersed)
        self.assertEqual(sorted(page.sections), sorted((*SECTIONS, "vorticity")))
        self.assertEqual(len(page.pictures), 6)
        for word in ("1.1", "grain cover in plain tiles", "83 %", "tau = 0.61", "5d0c0c9e5b7f2a11", "The ledger closes"):
            self.assertIn(word, text)
        self.assertIn("# &lt;b&gt;&amp;", text)
        with open(os.path.join(self.immersed, "picture.png"), "rb") as file:
            self.assertTrue(file.read().startswith(b"\x89PNG"))

    def test_work_across_the_coupling_is_shown_where_it_was_looked_at(self):
        folder = self.copy("work")
        path = os.path.join(folder, "summary.json")
        with open(path) as file:
            summary = json.load(file)
        energy = {"windows": 142, "given [J]": -3.05e-5, "taken [J]": -2.977e-5, "made [J]": 7.3e-7, "moved [J]": 5.9e-5}
        entry = {"edge": "water -> grains: load", "windows": 1000, "books": {}, "energy": energy}
        summary["participants"][0]["ledger"] = [entry, {"edge": "other", "energy": dict.fromkeys(energy, 0)}, {"edge": "x"}]
        with open(path, "w") as file:
            json.dump(summary, file)
        page, text = self.report(folder)
        self.assertIn("work", page.sections)
        for word in ("water -&gt; grains: load", "142", "-3.05e-05", "-2.977e-05", "1.2 %"):
            self.assertIn(word, text)
        self.assertNotIn("other", text.split("id=\"work\"")[1].split("</section>")[0])

    def test_dry_run_has_no_fluid_and_no_complaint(self):
        page, _ = self.report(self.dry)
        self.assertEqual(sorted(page.sections), sorted(SECTIONS))

    def test_several_runs_are_compared(self):
        page, text = self.report(self.immersed, self.dry)
        self.assertEqual(page.sections, ["facts", "run-out", "energy", "snapshots", "scene", "versions"])
        self.assertEqual(len(page.pictures), 3)
        self.assertIn("Dry collapse", text)

    def test_every_missing_file_is_named_and_the_page_still_made(self):
        for name in ("summary.json", "series.csv", "scene.yaml", "grains.h5", "water.h5"):
            with self.subTest(name):
                folder = self.copy("without_" + name)
                os.remove(os.path.join(folder, name))
                page, text = self.report(folder, draw=False)
                self.assertIn("missing", page.sections)
                self.assertIn(name, text)

    def test_an_empty_folder_still_makes_a_page(self):
        folder = os.path.join(self.folder, "empty")
        os.mkdir(folder)
        page, text = self.report(folder, draw=False)
        self.assertIn("missing", page.sections)
        self.report(folder, self.dry, draw=False)

    def test_broken_files_are_named(self):
        folder = self.copy("broken")
        for name, text in (("summary.json", "{\"title\": "), ("grains.h5", "no HDF5"), ("series.csv", "time [s]\n")):
            with open(os.path.join(folder, name), "w") as file:
                file.write(text)
        _, text = self.report(folder, draw=False)
        for word in ("not valid JSON", "series.csv has no rows"):
            self.assertIn(word, text)

    def test_a_truncated_archive_costs_only_its_pictures(self):
        folder = self.copy("truncated")
        with open(os.path.join(folder, "water.h5"), "r+b") as file:
            file.truncate(5000)
        page, text = self.report(folder, draw=False)
        self.assertIn("water.h5 cannot be read", text)
        self.assertIn("snapshots", page.sections)

    def test_no_grains_and_nan_speeds_are_drawn(self):
        import h5py

        folder = self.copy("odd", self.dry)
        with h5py.File(os.path.join(folder, "grains.h5"), "r+") as file:
            step = file["steps/000000"]
            for name in list(step):
                empty = step[name][:0]
                del step[name]
                step[name] = empty
            file["steps/000040/velocity"][0] = float("nan")
        page, _ = self.report(folder)
        self.assertEqual(sorted(page.sections), sorted(SECTIONS))

    def test_a_stopped_run_says_so(self):
        import json

        folder = self.copy("stopped", self.dry)
        path = os.path.join(folder, "summary.json")
        with open(path) as file:
            summary = json.load(file)
        summary["exit"] = summary["participants"][0]["exit"] = 6
        with open(path, "w") as file:
            json.dump(summary, file)
        _, text = self.report(folder, draw=False)
        self.assertIn("stopped, exit 6", text)
        self.assertIn("grains stopped with exit 6.", text)

    def test_a_fluid_alone_is_drawn(self):
        import json

        folder = self.copy("fluid_only")
        os.remove(os.path.join(folder, "grains.h5"))
        path = os.path.join(folder, "summary.json")
        with open(path) as file:
            summary = json.load(file)
        del summary["participants"][0]
        with open(path, "w") as file:
            json.dump(summary, file)
        page, text = self.report(folder)
        self.assertIn("vorticity", page.sections)
        self.assertIn("Speed of the fluid.", text)

    def test_a_continuum_beside_grains_is_drawn_with_them(self):
        folder = self.copy("bed", self.dry)
        shutil.copy(os.path.join(folder, "grains.h5"), os.path.join(folder, "soil.h5"))
        with h5py.File(os.path.join(folder, "soil.h5"), "r+") as file:
            for step in file["steps"].values():
                del step["radius"]
                step["position"][:, 0] += 1.0  # beside the grains
        path = os.path.join(folder, "summary.json")
        with open(path) as file:
            summary = json.load(file)
        summary["participants"].append({**summary["participants"][0], "name": "soil", "solver": "mpm"})
        with open(path, "w") as file:
            json.dump(summary, file)
        run = report.Run(folder)
        times = run.shown.times[:1]
        bed, grains = report.snapshots.clouds(run, times[0])
        self.assertAlmostEqual(bed.x.min() - grains.x.min(), 1.0)
        self.assertGreater(report.snapshots.view(run, times)[1], 1.0)
        self.assertEqual(run.matter, "grains and continuum")
        self.assertEqual(report.Run(self.dry).matter, "grains")
        self.report(folder, draw=False)

    def test_other_solvers_and_names_are_found(self):
        import json

        folder = self.copy("named")
        path = os.path.join(folder, "summary.json")
        with open(path) as file:
            summary = json.load(file)
        summary["participants"][0].update(name="sand", solver="bin/my_grains")
        summary["participants"][1].update(name="sea", solver="/opt/lbm")
        with open(path, "w") as file:
            json.dump(summary, file)
        os.rename(os.path.join(folder, "grains.h5"), os.path.join(folder, "sand.h5"))
        os.rename(os.path.join(folder, "water.h5"), os.path.join(folder, "sea.h5"))
        with open(os.path.join(folder, "series.csv")) as file:
            series = file.read().replace("grains.", "sand.").replace("water.", "sea.")
        with open(os.path.join(folder, "series.csv"), "w") as file:
            file.write(series)
        page, _ = self.report(folder, draw=False)
        self.assertEqual(sorted(page.sections), sorted((*SECTIONS, "vorticity")))

    def test_as_a_command(self):
        out = os.path.join(self.folder, "command.html")
        result = subprocess.run(["/usr/bin/python3", REPORT, self.dry, "--out", out], capture_output=True, text=True)
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        self.assertIn("command.html: ", result.stdout)

    def test_a_folder_that_is_not_there_is_a_usage_error(self):
        result = subprocess.run(["/usr/bin/python3", REPORT, "/nowhere"], capture_output=True, text=True)
        self.assertEqual(result.returncode, 2)
        self.assertIn("/nowhere is not a folder", result.stderr)


if __name__ == "__main__":
    unittest.main()
