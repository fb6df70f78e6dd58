"""Emitted C at many states beside Pinocchio: the largest difference as a share of a function's largest number."""

import ctypes
from pathlib import Path
from typing import Any

import numpy as np

import lwr_dyn
from lwr_dyn.codegen.emit.c_file import c_files
from lwr_dyn.codegen.emit.emission import emitted_arm
from lwr_dyn.codegen.kernels.kernel_spec import FUNCTIONS
from scripts.benchmarks.kernel_peers import pinocchio_answers
from tests.codegen.emit.programs import shared

COMPARED = ("inverse_dynamics", "forward_dynamics", "mass_matrix", "coriolis_matrix", "bias_torque", "gravity_vector",
            "flange_pose", "jacobian", "torque_regressor", "kinetic_energy", "potential_energy")  # fmt: skip
SHARE = 1e-14
LARGEST = np.array([np.pi, 2.0, 5.0])
"""Of q, dq, and of ddq or torques."""


def differences(name: str, count: int, folder: Path, *flags: str) -> dict[str, float]:
    """Function -> largest difference from Pinocchio over `count` states, as a share of its largest number there."""
    arm = lwr_dyn.load(name)
    emitted = emitted_arm(arm, COMPARED)
    texts = {str(path): text for path, text in c_files(emitted, folder / "arm.c").items()}
    texts[str(folder / "loops.c")] = '#include "arm.h"\n' + "".join(
        _loop(emitted.name_of(code.function.name), code.function) for code in emitted.codes
    )
    for path, text in texts.items():
        Path(path).write_text(text)
    loaded = shared(folder, ["arm.c", "loops.c"], *flags)
    x = np.random.default_rng(7).uniform(-1.0, 1.0, (3, count, arm.n)) * LARGEST[:, None, None]
    answers = pinocchio_answers(arm)
    return {code.function.name: _apart(loaded, emitted, code.function, x, answers) for code in emitted.codes}


def _apart(loaded: Any, emitted: Any, function: Any, x: np.ndarray, answers: Any) -> float:
    name, count = function.name, x.shape[1]
    given = x[: len(FUNCTIONS[name].states)]
    found = np.zeros((count, function.width))
    getattr(loaded, f"run_{emitted.name_of(name)}")(*(_pointer(row) for row in given), _pointer(found), count)
    expected = np.array([answers[name](*row) for row in zip(*given, strict=True)]).reshape(found.shape)
    if name == "potential_energy":
        found, expected = found - found[0], expected - expected[0]
    return float(np.abs(found - expected).max() / np.abs(expected).max())


def _loop(name: str, function: Any) -> str:
    heads = "".join(f"const double *{a.name}, " for a in function.arguments)
    given = "".join(f"{a.name} + {a.width} * k, " for a in function.arguments)
    return (
        f"void run_{name}({heads}double *out, int count);\nvoid run_{name}({heads}double *out, int count)\n{{\n"
        f"    for (int k = 0; k < count; k++) {name}({given}out + {function.width} * k);\n}}\n"
    )


def _pointer(array: np.ndarray) -> ctypes.c_void_p:
    assert array.flags.c_contiguous
    return ctypes.c_void_p(array.ctypes.data)
