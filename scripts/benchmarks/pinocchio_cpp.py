"""Emitted C against Pinocchio's C++ of the headers in its wheel, compiled here with -O3."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
import tempfile
from importlib.util import find_spec
from pathlib import Path

import numpy as np

import lwr_dyn
from benchmarks.emitted_code import CALLS, FAST, ROBOTS, STATES, arguments, loops
from benchmarks.timing import head, paired, row
from lwr_dyn.codegen.emit.functions import emitted_function
from lwr_dyn.codegen.kernels.kernel_spec import kernel_spec

PEERS = {"inverse_dynamics": "rnea", "mass_matrix": "crba", "forward_dynamics": "aba"}
_DEFINED = ("BOOST_MPL_CFG_NO_PREPROCESSED_HEADERS", "BOOST_MPL_LIMIT_LIST_SIZE=30", "BOOST_MPL_LIMIT_VECTOR_SIZE=30",
            "BOOST_FUSION_INVOKE_MAX_ARITY=12", "NDEBUG")  # fmt: skip
_SOURCE = Path(__file__).parent / "peers/pinocchio_loops.cpp"


def beside_cpp(pairs: int) -> None:
    """A row an arm and function; a line that says so where a compiler or headers are absent."""
    head("Emitted C, own sine and cosine, beside Pinocchio's C++")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        missing = _build(folder)
        if missing is not None:
            print(f"(Pinocchio's C++ is left out: {missing})")
            return
        library = ctypes.CDLL(str(folder / "peer.so"))
        for robot in ROBOTS:
            _rows(robot, library, folder, pairs)


def headers() -> tuple[Path, Path] | None:
    """Folders of Pinocchio's headers and of Eigen's, which CasADi's wheel holds."""
    casadi, prefix = find_spec("casadi"), find_spec("cmeel_pinocchio") or find_spec("pinocchio")
    if casadi is None or casadi.origin is None or prefix is None or prefix.origin is None:
        return None
    eigen = Path(casadi.origin).parent / "include/eigen3"
    above = [p for p in Path(prefix.origin).parents if (p / "include/pinocchio/algorithm/rnea.hpp").is_file()]
    return (above[0] / "include", eigen) if above and (eigen / "Eigen/Core").is_file() else None


def _build(folder: Path) -> str | None:
    """Compile the peer (minutes, 2 GB); returns what is missing for it."""
    compiler, found = shutil.which("g++"), headers()
    if compiler is None:
        return "no g++"
    if found is None:
        return "no headers of Pinocchio, or of Eigen"
    flags = [*(f"-D{name}" for name in _DEFINED), *(f"-I{path}" for path in found)]
    command = [compiler, "-std=c++17", "-O3", "-fPIC", "-shared", *flags, str(_SOURCE), "-o", str(folder / "peer.so")]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    return None if done.returncode == 0 else f"g++ says: {(done.stderr.splitlines() or ['nothing'])[0]}"


def _rows(robot: str, library: ctypes.CDLL, folder: Path, pairs: int) -> None:
    arm = lwr_dyn.load(robot)
    _load(library, lwr_dyn.dynamics_of(arm).ungated.model)
    for name, peer in PEERS.items():
        function = emitted_function(kernel_spec(arm), name, arm)
        own = folder / f"{robot}_{name}"
        own.mkdir()
        ours, _, _ = loops(function, "own", FAST, own)
        x, out = arguments(function), np.zeros(function.width)
        started = getattr(library, f"peer_{peer}")

        def theirs(started: object = started, x: np.ndarray = x, out: np.ndarray = out) -> None:
            started(_pointer(x), _pointer(out), ctypes.c_long(CALLS), ctypes.c_long(STATES - 1))  # type: ignore[operator]

        theirs()
        apart = np.abs(_expected(function, x) - _full(out, peer, arm.n)).max() / np.abs(out).max()
        a, b, ratio = paired(ours, theirs, pairs, 1)
        row(
            f"{robot} {name}", f"pinocchio::{peer} in C++, -O3", (a / CALLS, b / CALLS, ratio), f"differ by {apart:.0e}"
        )


def _load(library: ctypes.CDLL, model: object) -> None:
    joints = range(1, model.njoints)  # type: ignore[attr-defined]
    if any(model.joints[i].shortname() != "JointModelRZ" for i in joints):  # type: ignore[attr-defined]
        raise ValueError("the C++ peer knows joints about z alone")
    places = [model.jointPlacements[i] for i in joints]  # type: ignore[attr-defined]
    placement = np.array([[*p.rotation.ravel(), *p.translation] for p in places])
    inertia = np.array([model.inertias[i].toDynamicParameters() for i in joints])  # type: ignore[attr-defined]
    arrays = (placement, inertia, np.array(model.armature), np.array(model.gravity.linear))  # type: ignore[attr-defined]
    library.load(len(joints), *map(_pointer, arrays))


def _expected(function: object, x: np.ndarray) -> np.ndarray:
    """The result at the last state of a loop, by CasADi's virtual machine."""
    widths = [a.width for a in function.arguments]  # type: ignore[attr-defined]
    parts = np.split(x[(CALLS - 1) & (STATES - 1)], np.cumsum(widths)[:-1])
    return np.array(function.symbolic(*parts)).ravel()  # type: ignore[attr-defined]


def _full(out: np.ndarray, peer: str, n: int) -> np.ndarray:
    """Of B Pinocchio fills one triangle."""
    if peer != "crba":
        return out
    lower = np.tril(out.reshape(n, n))  # columns are stored one after another: their upper triangle
    return (lower + np.tril(lower, -1).T).ravel()


def _pointer(array: np.ndarray) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)
