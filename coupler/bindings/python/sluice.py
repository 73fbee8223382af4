"""Sluice for Python: one participant of a coupled run, over libsluice_c (ctypes, numpy; nothing is compiled or copied).

    def solve(self):
        step = self.config.number("step", unit="s")
        self.sends("kinematics"), self.takes("load")
        self.propose_window(step)
        self.config.finish()                                   # every mistake of the scene at once
        if self.checking: return
        self.write("water", "kinematics", ids, position=..., velocity=..., angular_velocity=..., radius=...)
        for window in self.windows():
            load = self.read("water", "load", window)
            ... advance from window.begin to window.end, sampling load.at(time).force ...
            self.write("water", "kinematics", ids, ...)

    if __name__ == "__main__":
        sluice.run(solve)

SI units. Arrays are float64 and C-contiguous, ids int64; a vector column has the shape (points, dimension), a scalar one
(points,). What is read are views of Sluice's own memory, read-only and valid until the next at() of the same edge or the
next window (or accepted()): copy what you keep. The meaning of every call is in sluice.h, whose functions these are.
"""
import ctypes
import json
import math
import os
import pathlib
import sys
import sysconfig
import traceback

import numpy as np

ABI = 1  # SLUICE_ABI of the sluice.h that this file was written for
INTERNAL, PROTOCOL, IO, INTERRUPTED = 70, 5, 7, 130  # exit codes, see the README

_FLOAT64, _INT64, _BYTES = 0, 1, 2
_TYPES = {_FLOAT64: np.dtype(np.float64), _INT64: np.dtype(np.int64), _BYTES: np.dtype(np.uint8)}


class SluiceError(RuntimeError):
    """What went wrong; `exit` is the code that the process should end with."""

    def __init__(self, message, exit=INTERNAL):
        super().__init__(message)
        self.exit = exit


class Window(ctypes.Structure):
    """Times in s; output, series, last: 0 or 1."""
    _fields_ = [("index", ctypes.c_int64), ("begin", ctypes.c_double), ("end", ctypes.c_double),
                ("length", ctypes.c_double), ("output", ctypes.c_int), ("series", ctypes.c_int),
                ("last", ctypes.c_int), ("iteration", ctypes.c_int)]

    def steps(self, longest):
        """How many equal steps of at most `longest` seconds fill the window."""
        return max(1, math.ceil(self.length / longest - 1e-9))

    def time(self, k, steps):
        """The k-th of `steps` times that divide the window evenly, begin and end exactly."""
        return self.begin if k == 0 else self.end if k == steps else self.begin + self.length * (k / steps)


class _About(ctypes.Structure):
    _fields_ = [("name", ctypes.c_char_p), ("directory", ctypes.c_char_p), ("scene", ctypes.c_char_p),
                ("gravity", ctypes.c_double * 3), ("end", ctypes.c_double), ("resumed_at", ctypes.c_double),
                ("dimension", ctypes.c_int), ("rank", ctypes.c_int), ("ranks", ctypes.c_int),
                ("checking", ctypes.c_int), ("resumes", ctypes.c_int)]


class _Frame(ctypes.Structure):
    _fields_ = [("points", ctypes.c_size_t), ("ids", ctypes.c_void_p), ("columns", ctypes.c_size_t),
                ("column", ctypes.POINTER(ctypes.c_void_p)), ("components", ctypes.POINTER(ctypes.c_size_t))]


_Callback = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_void_p)
_library = None


def _places():
    """Where the library may lie: as SLUICE_LIBRARY says; beside this file; where an installation puts it; anywhere."""
    if os.environ.get("SLUICE_LIBRARY"):
        return [os.environ["SLUICE_LIBRARY"]]
    here = pathlib.Path(__file__).resolve().parent
    installed = here.parents[1] if len(here.parents) > 1 else here  # PREFIX/lib of PREFIX/lib/python3/dist-packages
    folders = [here, installed / (sysconfig.get_config_var("MULTIARCH") or ""), installed]
    files = [file for folder in folders for file in sorted(folder.glob("libsluice_c.so*"))[:1]]
    return [str(file) for file in files] + ["libsluice_c.so.0.1", "libsluice_c.so"]


def _load():
    """The library, once. SluiceError: not found (7), or of another version (5)."""
    global _library
    if _library is None:
        failures = []
        for place in _places():
            try:
                found = ctypes.CDLL(place)
                break
            except OSError as e:
                failures.append(str(e))
        else:
            raise SluiceError("sluice.py: cannot load libsluice_c (" + "; ".join(failures) +
                              "). Install Sluice, or set SLUICE_LIBRARY to the file.", IO)
        found.sluice_version.restype = found.sluice_error.restype = ctypes.c_char_p
        number = ctypes.c_int()
        version = found.sluice_version(ctypes.byref(number)).decode()
        if number.value != ABI:
            raise SluiceError(f"sluice.py: {found._name} is of Sluice {version} with interface {number.value}, this file "
                              f"needs {ABI} (must match). Use the sluice.py of that version.", PROTOCOL)
        _library = found
    return _library


def _view(address, shape, dtype):
    """The memory at `address` as a read-only array, without a copy."""
    size = math.prod(shape)
    if size == 0:
        return np.empty(shape, dtype)
    array = np.frombuffer((ctypes.c_char * (size * dtype.itemsize)).from_address(address), dtype).reshape(shape)
    array.flags.writeable = False
    return array


def _address(array):
    return array.__array_interface__["data"][0]


def _names(words):
    return (ctypes.c_char_p * (len(words) + 1))(*[word.encode() for word in words], None)


class Frame:
    """What an edge says at one time: `ids`, and one attribute for each column of the data, e.g. `force`."""

    def __init__(self, ids, columns):
        self.ids = ids
        self.__dict__.update(columns)


class Samples:
    """What an edge says inside one window."""

    def __init__(self, participant, sender, data, window):
        self._participant, self._sender, self._data, self._window = participant, sender, data, window
        self._ids = None

    def at(self, time):
        """All columns at a time of the window [s]. The views of the last call are overwritten."""
        frame = self._participant._read(self._sender, self._data, time)
        self._ids = frame.ids
        return frame

    @property
    def ids(self):
        return self._ids if self._ids is not None else self.at(self._window.end).ids


class Config:
    """The participant's `config` block. Mistakes are collected; finish() raises all of them at once."""

    def __init__(self, participant):
        self._participant = participant

    def numbers(self, key, count, unit="", default=None):
        """An array of `count` numbers; without a default the key must be there."""
        values = (ctypes.c_double * count)()
        fallback = None if default is None else (ctypes.c_double * count)(*default)
        self._participant._call("number", key.encode(), unit.encode(), ctypes.c_size_t(count), fallback, values)
        return np.array(values)

    def number(self, key, unit="", default=None):
        return float(self.numbers(key, 1, unit, None if default is None else [default])[0])

    def text(self, key, default=None):
        value = ctypes.c_char_p()
        self._participant._call("text", key.encode(), None if default is None else default.encode(), ctypes.byref(value))
        return value.value.decode()

    def flag(self, key, default=False):
        value = ctypes.c_int()
        self._participant._call("flag", key.encode(), int(default), ctypes.byref(value))
        return bool(value.value)

    def refuse(self, key, text):
        """A mistake of the value that only the solver can see, e.g. "(must be even)."."""
        self._participant._call("refuse", key.encode(), text.encode())

    def finish(self):
        self._participant._call("end_config")


class Participant:
    """One participant, as the command line says; run() makes it."""

    def __init__(self, argv):
        self._handle, self._raised, self._data, self._callbacks = ctypes.c_void_p(), None, {}, None
        words = (ctypes.c_char_p * len(argv))(*[os.fsencode(word) for word in argv])
        library = _load()
        status = library.sluice_join(ABI, len(argv), words, ctypes.byref(self._handle))
        if status != 0:
            raise SluiceError(library.sluice_error(None).decode(), status)
        if self.joined:
            about = self._about()
            self.name, self.scene = about.name.decode(), pathlib.Path(os.fsdecode(about.scene))
            self.directory = pathlib.Path(os.fsdecode(about.directory))
            self.dimension, self.gravity, self.end = about.dimension, tuple(about.gravity), about.end  # m/s2, s
            self.rank, self.ranks = about.rank, about.ranks
            self.checking, self.resumes = bool(about.checking), bool(about.resumes)
            self.config = Config(self)

    @property
    def joined(self):
        """False after --help and --version: there is nothing to do."""
        return self._handle.value is not None

    @property
    def resumed_at(self):
        """s; after windows() has begun."""
        return self._about().resumed_at

    def sends(self, *data):
        self._call("exchanges", _names(data), None)

    def takes(self, *data):
        self._call("exchanges", None, _names(data))

    def receivers(self, data):
        """The names at the other end of the edges that carry `data` away."""
        return self._partners(data, 1)

    def senders(self, data):
        return self._partners(data, 0)

    def propose_window(self, seconds, exact=False):
        self._call("propose_window", ctypes.c_double(seconds), int(exact))

    def covers(self, low, high):
        """The part of space that this process covers: two corners [m]. low above high in x: nothing, no points."""
        corner = ctypes.c_double * 3
        self._call("covers", corner(*low), corner(*high))

    def keeps(self, save, restore):
        """`save()` returns a dict of all that the solver needs to go on bit for bit: arrays of float64, int64 or uint8,
        numbers, bytes. `restore(dict)` gets the same; arrays are copies that are the solver's own."""
        self._callbacks = (_Callback(lambda _, state: self._guarded(lambda: self._save(state, save()))),
                           _Callback(lambda _, state: self._guarded(lambda: restore(self._restored(state)))))
        self._call("keeps", *self._callbacks, None)

    def windows(self):
        """Meets the others, then yields one window after the other."""
        more = ctypes.c_int()
        while True:
            window = Window()
            self._call("next", ctypes.byref(window), ctypes.byref(more))
            if not more.value:
                return
            yield window

    def read(self, sender, data, window):
        return Samples(self, sender, data, window)

    def write(self, to, data, ids, /, **columns):
        """The state for an out-edge, before the first window and at the end of each; the columns by their names."""
        specs = self._columns(data)
        names = [name for name, _ in specs]
        if sorted(names) != sorted(columns):
            raise SluiceError(f'participant "{self.name}" wrote {data} with {", ".join(columns) or "nothing"} '
                              f'(its columns: {", ".join(names)}).')
        self._require(f"{data}: ids", ids, np.int64, [(np.size(ids),)])
        points = len(ids)
        for name, width in specs:
            self._require(f"{data}.{name}", columns[name], np.float64,
                          [(points,), (points, 1)] if width == 1 else [(points, width), (points * width,)])
        addresses = (ctypes.c_void_p * len(specs))(*[_address(columns[name]) for name in names])
        sizes = (ctypes.c_size_t * len(specs))(*[columns[name].size for name in names])
        self._call("write", to.encode(), data.encode(), ctypes.c_size_t(points), ctypes.c_void_p(_address(ids)),
                   ctypes.c_size_t(len(specs)), addresses, sizes)

    def accepted(self, window):
        """After the last write of a window: False only in an implicit group, when it will be computed again."""
        yes = ctypes.c_int()
        self._call("accepted", ctypes.byref(yes))
        return bool(yes.value)

    def next_window(self, seconds):
        self._call("request", 0, ctypes.c_double(seconds), None)

    def end_run(self, why):
        self._call("request", 1, ctypes.c_double(0), why.encode())

    def request_checkpoint(self):
        self._call("request", 2, ctypes.c_double(0), None)

    def fact(self, name, value):
        """A figure for the report."""
        self._call("fact", name.encode(), ctypes.c_double(value))

    def warn(self, text):
        self._call("warn", text.encode())

    def leave(self, status=0, message=None):
        """The end, called by run(). Returns what the process should end with."""
        handle, self._handle = self._handle, ctypes.c_void_p()
        return _load().sluice_leave(handle, status, None if message is None else message.encode())

    def _call(self, name, *arguments):
        status = getattr(_library, "sluice_" + name)(self._handle, *arguments)
        if status == 0:
            return
        if self._raised is not None:  # in one of our callbacks
            raise self._raised
        raise SluiceError(_library.sluice_error(None).decode(), status)

    def _about(self):
        about = _About()
        self._call("get_about", ctypes.byref(about))
        return about

    def _partners(self, data, outgoing):
        names, name = [], ctypes.c_char_p()
        while True:
            self._call("partner", data.encode(), outgoing, ctypes.c_size_t(len(names)), ctypes.byref(name))
            if name.value is None:
                return names
            names.append(name.value.decode())

    def _columns(self, data):
        """(name, numbers a point) of each column."""
        if data not in self._data:
            specs, name, unit, width = [], ctypes.c_char_p(), ctypes.c_char_p(), ctypes.c_size_t()
            while True:
                self._call("column", data.encode(), ctypes.c_size_t(len(specs)), ctypes.byref(name), ctypes.byref(unit),
                           ctypes.byref(width))
                if name.value is None:
                    break
                specs.append((name.value.decode(), width.value))
            self._data[data] = specs
        return self._data[data]

    def _read(self, sender, data, time):
        frame = _Frame()
        self._call("read", sender.encode(), data.encode(), ctypes.c_double(time), ctypes.byref(frame))
        points = frame.points
        return Frame(_view(frame.ids, (points,), _TYPES[_INT64]),
                     {name: _view(frame.column[c], (points,) if width == 1 else (points, width), _TYPES[_FLOAT64])
                      for c, (name, width) in enumerate(self._columns(data))})

    def _require(self, what, array, dtype, shapes):
        """Throws unless the array can be handed over as it is."""
        wanted = np.dtype(dtype)
        where = f'participant "{self.name}": write of {what}: '
        if not isinstance(array, np.ndarray):
            raise SluiceError(f"{where}a {type(array).__name__} (needed: a numpy array of {wanted}).")
        if array.dtype != wanted:
            raise SluiceError(f"{where}{array.dtype} (needed: {wanted}). Try numpy.asarray(a, numpy.{wanted}).")
        if array.shape not in shapes:
            raise SluiceError(f"{where}shape {array.shape} (needed: {' or '.join(map(str, shapes))}).")
        if not array.flags.c_contiguous:
            raise SluiceError(f"{where}not contiguous (needed: C order). Try numpy.ascontiguousarray(a).")

    def _guarded(self, work):
        """`work` called from C: an exception waits for the call around it."""
        try:
            work()
            return 0
        except BaseException as e:
            self._raised = e
            return e.exit if isinstance(e, SluiceError) else INTERNAL

    def _checked(self, status):
        if status != 0:
            raise SluiceError(_library.sluice_error(None).decode(), status)

    def _put(self, state, name, kind, array):
        self._checked(_library.sluice_put(ctypes.c_void_p(state), name.encode(), kind, ctypes.c_void_p(_address(array)),
                                          ctypes.c_size_t(array.size)))

    def _get(self, state, name, kind):
        values, size = ctypes.c_void_p(), ctypes.c_size_t()
        self._checked(_library.sluice_get(ctypes.c_void_p(state), name.encode(), kind, ctypes.byref(values),
                                          ctypes.byref(size)))
        return _view(values.value, (size.value,), _TYPES[kind]).copy()

    def _save(self, state, kept):
        """Every array as `state/NAME`; `index` tells how they are to be read."""
        index = {}
        for name, value in kept.items():
            array = np.ascontiguousarray(np.array(bytearray(value), np.uint8) if isinstance(value, bytes) else value)
            kinds = [kind for kind, dtype in _TYPES.items() if dtype == array.dtype]
            if not kinds:
                raise SluiceError(f'participant "{self.name}" keeps {name} as {array.dtype} (needed: float64, int64, '
                                  "uint8 or bytes).")
            index[name] = [kinds[0], list(array.shape if isinstance(value, bytes) else np.shape(value)), type(value).__name__]
            self._put(state, "state/" + name, kinds[0], array)
        self._put(state, "index", _BYTES, np.frombuffer(json.dumps(index).encode(), np.uint8))

    def _restored(self, state):
        kept = {}
        for name, (kind, shape, how) in json.loads(self._get(state, "index", _BYTES).tobytes()).items():
            array = self._get(state, "state/" + name, kind)
            if how == "bytes":
                kept[name] = array.tobytes()
            elif how == "ndarray" or shape:
                kept[name] = array.reshape(shape)
            else:
                kept[name] = array.item() if how in ("int", "float") else array[0]
        return kept


def _failure(participant, error):
    """Exit code and message of an exception in a solver."""
    name = getattr(participant, "name", "?")
    if isinstance(error, SluiceError):
        return error.exit, str(error)
    if isinstance(error, KeyboardInterrupt):
        return INTERRUPTED, f'participant "{name}": interrupted from the keyboard.'
    if isinstance(error, MemoryError):
        return IO, f'participant "{name}": out of memory. Make the scene smaller.'
    last = traceback.extract_tb(error.__traceback__)[-1]
    return INTERNAL, (f'participant "{name}": {type(error).__name__}: {error} '
                      f"({os.path.basename(last.filename)}:{last.lineno})\n{''.join(traceback.format_exception(error))}")


def run(solve, argv=None):
    """A whole program: command line, scene, solve(participant), exit code. Does not return. An exception of the solver
    ends the participant with its traceback as the message, for the others and the launcher too (exit 70)."""
    participant, status, message = None, 0, None
    try:
        participant = Participant(sys.argv if argv is None else argv)
        if participant.joined:
            solve(participant)
    except BaseException as e:  # whatever it is, the others must hear of it
        status, message = _failure(participant, e)
    if participant is not None:
        status = participant.leave(status, message)
    elif message:
        print(message, file=sys.stderr)
    sys.exit(status)
