"""Emitted C of all functions at many states beside Pinocchio, and with hard numbers under the sanitizers."""

from __future__ import annotations

import tempfile
from pathlib import Path

import lwr_dyn
from lwr_dyn.foundation.tables import aligned

STATES, CALLS = 100_000, 20_000
BUILDS = (("-O2", "-std=c99", "-fno-tree-slp-vectorize"), ("-O2", "-march=native", "-ffp-contract=fast"))


def emitted_states() -> tuple[str, bool, str]:
    """Emitted C of 11 functions of 3 arms at 100 000 states beside Pinocchio, as a share of the largest number."""
    from tests.codegen.emit.emitted_robots import ARMS
    from tests.codegen.emit.many_states import SHARE, differences

    rows, worst = [], 0.0
    for arm in ARMS:
        for flags in BUILDS:
            with tempfile.TemporaryDirectory() as folder:
                found = differences(arm, STATES, Path(folder), *flags)
            at = max(found, key=lambda name: found[name])
            rows.append((arm, " ".join(flags), f"{found[at]:.1e}", at))
            worst = max(worst, found[at])
    return f"{len(rows)} builds, worst {worst:.1e}", worst < SHARE, aligned(rows, ("arm", "flags", "worst", "of"))


def emitted_sanitized() -> tuple[str, bool, str]:
    """Every emitted function of 3 arms, 20 000 calls with NaN, inf, 1e300 and denormals, address and UB sanitizers."""
    from lwr_dyn.codegen.emit.emission import emitted_arm
    from tests.codegen.emit.emitted_robots import ARMS
    from tests.codegen.emit.hard_numbers import SANITIZERS, write_program
    from tests.codegen.emit.programs import output

    rows, total = [], 0
    cases = [{}, {"kind": "libm"}, {"dtype": "float32"}, {"inputs": ("payload", "gravity", "friction", "inertia")}]
    for arm in ARMS:
        for options in cases:
            emitted = emitted_arm(lwr_dyn.load(arm), **options)  # type: ignore[arg-type]
            for compiler in ("gcc", "clang"):
                with tempfile.TemporaryDirectory() as name:
                    files = write_program(emitted, Path(name), CALLS)
                    command = [compiler, "-O1", "-std=c99", *SANITIZERS, *files, "-lm", "-o", "hard"]
                    output(command, Path(name), seconds=900)
                    calls = int(output([str(Path(name) / "hard")], Path(name)))
                total += calls
                functions = str(len(emitted.codes) + len(emitted.templates))
                rows.append((arm, compiler, str(options) if options else "as it is", functions, str(calls)))
    return f"{total} calls, silent", True, aligned(rows, ("arm", "compiler", "options", "functions", "calls"))
