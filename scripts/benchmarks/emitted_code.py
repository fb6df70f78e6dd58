"""C of `lwr-dyn kernels --language c` against CasADi's C of the same expressions, and against Pinocchio from Python."""

from __future__ import annotations

import ctypes
import os
import statistics
import subprocess
import tempfile
from pathlib import Path

import casadi
import numpy as np
import pinocchio as pin

import lwr_dyn
from benchmarks.timing import Call, paired, row, seconds
from lwr_dyn.codegen.emit.c_file import c_function
from lwr_dyn.codegen.emit.functions import EmittedFunction, SinCosKind, emitted_code, emitted_function
from lwr_dyn.codegen.kernels.kernel_spec import kernel_spec

ROBOTS = ("lwr4plus", "wam7", "kr30ha")
FUNCTIONS = ("inverse_dynamics", "forward_dynamics", "mass_matrix", "coriolis_matrix", "gravity_vector", "flange_pose",
             "jacobian", "torque_regressor")  # fmt: skip
FAST = "-O2 -std=c99 -march=native -ffp-contract=fast -fno-tree-slp-vectorize"
BUILDS: tuple[tuple[SinCosKind, str], ...] = (("libm", FAST), ("own", FAST), ("libm", "-O2 -std=c99"))
CALLS, STATES = 3000, 64
_LOOPS = """
void run_ours(const double *x, double *out, long m)
{{ for (long i = 0; i < m; i++) {{ const double *p = x + (i & {last}) * {step}; ours({ours}, out); }} }}
int theirs(const double **arg, double **res, long long *iw, double *w, int mem);
void run_theirs(const double *x, double *out, long m)
{{
    const double *arg[8]; double *res[4] = {{out}}; long long iw[4]; static double w[20000];
    for (long i = 0; i < m; i++) {{ const double *p = x + (i & {last}) * {step}; {theirs} theirs(arg, res, iw, w, 0); }}
}}
"""


def loops(function: EmittedFunction, kind: SinCosKind, flags: str, folder: Path) -> tuple[Call, Call, float]:
    """Ours and CasADi's, `CALLS` times over some states, and the largest difference of the results."""
    widths = [a.width for a in function.arguments]
    starts = [sum(widths[:i]) for i in range(len(widths))]
    symbols = [casadi.SX.sym(a.name, a.width) for a in function.arguments]
    there = os.getcwd()
    os.chdir(folder)  # CasADi writes into the present folder only
    try:
        casadi.Function("theirs", symbols, function.symbolic.call(symbols)).generate("theirs.c")
    finally:
        os.chdir(there)
    calls = _LOOPS.format(
        last=STATES - 1, step=sum(widths), ours=", ".join(f"p + {s}" for s in starts),
        theirs=" ".join(f"arg[{i}] = p + {s};" for i, s in enumerate(starts)),
    )  # fmt: skip
    text = "#include <math.h>\n" + c_function(emitted_code(function, kind), "ours", "restrict") + calls
    (folder / "ours.c").write_text(text, encoding="ascii")
    library = folder / "both.so"
    subprocess.run(["gcc", *flags.split(), "-fPIC", "-shared", folder / "ours.c", folder / "theirs.c", "-lm", "-o",
                    library], check=True, stderr=subprocess.DEVNULL)  # fmt: skip
    both = ctypes.CDLL(str(library))
    x = arguments(function)
    out = np.zeros((2, function.width))

    def call(run: str, place: int) -> Call:
        started = getattr(both, run)
        return lambda: started(_pointer(x), _pointer(out[place]), ctypes.c_long(CALLS))  # keeps x and out alive

    ours, theirs = call("run_ours", 0), call("run_theirs", 1)
    ours(), theirs()
    return ours, theirs, float(np.abs(out[0] - out[1]).max() / np.abs(out[1]).max())


def arguments(function: EmittedFunction) -> np.ndarray:
    """The states of a loop, a state a row."""
    return np.random.default_rng(0).uniform(-2.0, 2.0, (STATES, sum(a.width for a in function.arguments)))


def _pointer(array: np.ndarray) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)


def emitted(pairs: int) -> None:
    """The table; then inverse dynamics of the LWR 4+ against Pinocchio called from Python."""
    for kind, flags in BUILDS:
        print(f"\n### C beside CasADi's C, sine and cosine {kind}, gcc {flags}\n")
        print("| function | ours [us] | peer | theirs [us] | ours / peer | note |\n|---|---|---|---|---|---|")
        for name in ROBOTS:
            spec, arm = kernel_spec(lwr_dyn.load(name)), lwr_dyn.load(name)
            for each in FUNCTIONS:
                with tempfile.TemporaryDirectory() as folder:
                    ours, theirs, apart = loops(emitted_function(spec, each, arm), kind, flags, Path(folder))
                    a, b, ratio = paired(ours, theirs, pairs, 1)
                row(f"{name} {each}", "CasADi's C", (a / CALLS, b / CALLS, ratio), f"differ by {apart:.0e}")
    _beside_pinocchio(pairs)


def _beside_pinocchio(pairs: int) -> None:
    arm = lwr_dyn.load("lwr4plus")
    dyn = lwr_dyn.dynamics_of(arm)
    model, data = dyn.ungated.model, dyn.ungated.data
    q, dq, ddq = np.random.default_rng(0).uniform(-1, 1, (3, arm.n))
    function = emitted_function(kernel_spec(arm), "inverse_dynamics", arm)
    with tempfile.TemporaryDirectory() as folder:
        ours, _, _ = loops(function, "own", FAST, Path(folder))
        ours()
        theirs: Call = lambda: pin.rnea(model, data, q, dq, ddq)  # noqa: E731
        rounds = [(seconds(ours, 1) / CALLS, seconds(theirs, CALLS)) for _ in range(pairs)]
    ratio = statistics.median(a / b for a, b in rounds)
    medians = [statistics.median(x) for x in zip(*rounds, strict=True)]
    row("lwr4plus inverse_dynamics", "pin.rnea from Python", (medians[0], medians[1], ratio))
