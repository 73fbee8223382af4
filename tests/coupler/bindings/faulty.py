"""A spring that does what the key `fault` of its config says, once, in window 3 (or before the first window)."""
import ctypes
import os
import signal
import time

import numpy as np
import sluice

ONE = np.zeros(1, np.int64)


def same_memory(self, window, partner):
    """Views are where the library's pointers point, and cannot be written to."""
    seen = self.read(partner, "place", window).at(window.end)
    raw = sluice._Frame()
    self._call("read", partner.encode(), b"place", ctypes.c_double(window.end), ctypes.byref(raw))
    assert seen.place.__array_interface__["data"] == (raw.column[0], True)
    assert seen.ids.__array_interface__["data"] == (raw.ids, True)
    assert seen.place.shape == (1,) and raw.points == 1
    library_saw = []

    class Spy:  # stands before the library: what addresses does a write hand over?
        def __getattr__(self, name):
            return lambda *a: library_saw.append(a) or getattr(real, name)(*a)
    real, sluice._library = sluice._library, Spy()
    ids, place = np.array([0], np.int64), np.array([0.5])
    self.write(partner, "place", ids, place=place)
    sluice._library = real
    (_, _, _, _, its_ids, _, columns, _), = library_saw
    assert its_ids.value == ids.ctypes.data and columns[0] == place.ctypes.data
    self.fact("same memory", 1)


def solve(self):
    x, v = self.config.number("start", unit="m"), 0.0
    fault = self.config.text("fault", "none")
    log = self.config.text("log", "")
    nap = self.config.number("nap", unit="s", default=0)
    self.config.flag("flag")
    self.config.numbers("list", 3, default=[1, 2, 3])
    self.sends("place")
    self.takes("place")
    if fault == "refuse":
        self.config.refuse("start", "m will not do.")
    self.config.finish()
    if self.checking:
        return
    partner = self.receivers("place")[0]

    def tell(place=None, ids=ONE):
        self.write(partner, "place", ids, place=np.array([x]) if place is None else place)

    class Grid:  # some state of every type
        cells = np.arange(6.0).reshape(2, 3)
        counts = np.array([[1], [2]])
        mask = np.array([True, False]).astype(np.uint8)

    def save():
        if fault == "save":
            raise ValueError("no state today")
        return {"x": x, "v": v, "n": self.windows_seen, "cells": Grid.cells, "counts": Grid.counts, "mask": Grid.mask,
                "none": np.empty(0), "word": b"abc", "nothing": b""}

    def restore(kept):
        nonlocal x, v
        x, v, self.windows_seen = kept["x"], kept["v"], kept["n"]
        assert (kept["cells"] == Grid.cells).all() and kept["cells"].flags.writeable
        assert (kept["counts"] == Grid.counts).all() and (kept["mask"] == Grid.mask).all()
        assert kept["none"].size == 0 and kept["word"] == b"abc" and kept["nothing"] == b""
        assert type(self.windows_seen) is int and isinstance(x, float) and isinstance(v, float)

    self.windows_seen, repeated = 0, 0
    self.keeps(save, restore)
    if fault == "read before":
        self.read(partner, "place", sluice.Window()).at(0)
    if fault == "stale":
        return self.write("nobody", "place", ONE, place=np.zeros(1))
    if not self.resumes and fault != "no write before":
        tell()
    old = None
    for window in self.windows():
        if self.resumes and self.windows_seen != window.index:
            raise AssertionError(f"{self.windows_seen} is not {window.index}")
        other = self.read(partner, "place", window)
        pull = lambda t: -39.5 * x - 157.9 * (x - other.at(t).place[0])  # N
        v += window.length / 2 * pull(window.begin)
        x += window.length * v
        v += window.length / 2 * pull(window.end)
        time.sleep(nap)
        self.windows_seen += 1
        if window.index == 3:
            if fault == "nan": x = float("nan")
            if fault == "float32": tell(np.zeros(1, np.float32))
            if fault == "int ids": tell(ids=np.zeros(1, np.int32))
            if fault == "list": tell([0.0])
            if fault == "shape": tell(np.zeros((1, 2)))
            if fault == "points": tell(np.zeros(2))
            if fault == "strided": tell(np.zeros(4)[::2], np.zeros(2, np.int64))
            if fault == "no column": self.write(partner, "place", ONE, plaice=np.zeros(1))
            if fault == "no partner": self.write("nobody", "place", ONE, place=np.zeros(1))
            if fault == "no data": self.read(partner, "load", window).at(window.end)
            if fault == "outside": other.at(window.end + window.length)
            if fault == "old samples": old.at(old._window.begin)
            if fault == "twice": tell()
            if fault == "raise": raise ValueError("grain 7 is gone")
            if fault == "interrupt": os.kill(os.getpid(), signal.SIGINT)
            if fault == "memory": raise MemoryError
            if fault == "exit": raise SystemExit(0)
            if fault == "pace": self.next_window(0.01)
            if fault == "end": self.end_run("enough")
            if fault == "checkpoint": self.request_checkpoint()
            if fault == "go on": # after a failure nothing works any more
                for _ in range(2):
                    try:
                        self.write("nobody", "place", ONE, place=np.zeros(1))
                    except sluice.SluiceError as e:
                        first = str(e)
                try:
                    self.fact("x", 1)
                except sluice.SluiceError as e:
                    assert str(e) == first and e.exit == 70
                    return
            if fault == "same memory":
                same_memory(self, window, partner)
                continue
        if not (fault == "no write" and window.index == 3):
            tell()
        if not self.accepted(window):
            repeated += 1
            continue
        old = other
        if log:
            with open(log, "a") as file:
                print(window.index, repr(x), file=file)
    self.fact("place at the end [m]", x)
    self.fact("windows seen", self.windows_seen)
    self.fact("windows repeated", repeated)


if __name__ == "__main__":
    sluice.run(solve)
