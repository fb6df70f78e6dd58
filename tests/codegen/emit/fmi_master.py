"""A small master: loads the binary of an FMU through ctypes and calls the functions of FMI 3 or 2."""

import ctypes
import zipfile
from xml.etree import ElementTree

import numpy as np

_D, _S, _P = ctypes.c_double, ctypes.c_size_t, ctypes.c_void_p


class Instance:
    """An instance of an FMU with arrays by name; both versions look the same from outside."""

    def __init__(self, archive, folder):
        with zipfile.ZipFile(archive) as every:
            every.extractall(folder)
        tree = ElementTree.parse(folder / "modelDescription.xml").getroot()
        self.version = tree.attrib["fmiVersion"][0]
        binary = next((folder / "binaries").rglob("*.so"))
        self.library, self.references = ctypes.CDLL(str(binary)), {}
        for x in tree.find("ModelVariables"):
            name = x.attrib["name"].partition("[")[0]
            width = int(np.prod([int(d.attrib["start"]) for d in x.findall("Dimension")], dtype=int))
            self.references.setdefault(name, []).append((int(x.attrib["valueReference"]), width))
        token = tree.attrib.get("instantiationToken") or tree.attrib["guid"]
        self.handle = self.instantiated(token)
        assert self.handle
        self.ended = False

    def instantiated(self, token):
        name, arguments = ("fmi3InstantiateCoSimulation", [None, 0, 0, 0, 0, None, _S(0), None, None, None])
        if self.version == "2":
            name, arguments = "fmi2Instantiate", [1, token.encode(), None, None, 0, 0]
            return self._pointer(name, b"x", *arguments)
        return self._pointer(name, b"x", token.encode(), *arguments)

    def _pointer(self, name, *arguments):
        function = getattr(self.library, name)
        function.restype = _P
        return function(*arguments)

    def call(self, name, *arguments):
        return getattr(self.library, f"fmi{self.version}{name}")(_P(self.handle), *arguments)

    def _access(self, kind, name, values):
        rows = self.references[name]
        references, count = (ctypes.c_uint32 * len(rows))(*(r for r, _ in rows)), sum(w for _, w in rows)
        assert len(values) == count
        more = [_S(count)] if self.version == "3" else []
        word = {"2": "Real", "3": "Float64"}[self.version]
        return self.call(f"{kind}{word}", references, _S(len(rows)), values, *more)

    def set(self, name, values):
        flat = np.ravel(values).tolist()
        assert self._access("Set", name, (_D * len(flat))(*flat)) == 0

    def get(self, name):
        out = (_D * sum(w for _, w in self.references[name]))()
        assert self._access("Get", name, out) == 0
        return np.array(out)

    def begin(self, **values):
        for name, value in values.items():
            self.set(name, value)
        if self.version == "2":
            assert self.call("SetupExperiment", 0, _D(0), _D(0), 0, _D(0)) == 0
            assert self.call("EnterInitializationMode") == 0
        else:
            assert self.call("EnterInitializationMode", 0, _D(0), _D(0), 0, _D(0)) == 0
        assert self.call("ExitInitializationMode") == 0

    def step(self, t, h):
        if self.version == "2":
            return self.call("DoStep", _D(t), _D(h), 0)
        flags = [ctypes.byref(ctypes.c_bool()) for _ in range(3)]
        return self.call("DoStep", _D(t), _D(h), 0, *flags, ctypes.byref(_D()))

    def derivatives(self, x):
        out = (_D * len(x))()
        assert self.call("SetContinuousStates", (_D * len(x))(*x), _S(len(x))) == 0
        name = "GetDerivatives" if self.version == "2" else "GetContinuousStateDerivatives"
        assert self.call(name, out, _S(len(x))) == 0
        return np.array(out)

    def directional(self, unknown, known, seed):
        """(status, derivative of a variable along a direction of another)."""
        rows = [self.references[x] for x in (unknown, known)]
        references = [(ctypes.c_uint32 * len(x))(*(r for r, _ in x)) for x in rows]
        out, given = (_D * sum(w for _, w in rows[0]))(), (_D * len(seed))(*seed)
        places = [x for pair in zip(references, map(_S, map(len, rows)), strict=True) for x in pair]
        sizes = [[_S(len(x))] if self.version == "3" else [] for x in (given, out)]
        status = self.call("GetDirectionalDerivative", *places, given, *sizes[0], out, *sizes[1])
        return status, np.array(out)
