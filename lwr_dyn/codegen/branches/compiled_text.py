"""The text of a closed form as a function in memory: of this process, from the cache, or compiled now by LLVM alone.

Python calls it as it calls C, where that road is open (`single_state`); else through ctypes, with room for each thread.
"""

import threading
from collections.abc import Mapping
from functools import partial
from importlib.metadata import version
from importlib.resources import files
from typing import Any

import numpy as np
from llvmlite import binding as llvm

from lwr_dyn.codegen.kernels.kernel import address, cache_name, kept_code
from lwr_dyn.codegen.kernels.llvm_text import DECLARATIONS, llvm_text, table, table_places
from lwr_dyn.codegen.kernels.machine_code import LoadedCode, host_cpu, optimise, target_machine
from lwr_dyn.codegen.kernels.single_state import Signature, closed_because, single_call
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.kinematics.closed_forms.runners import ENTRY, ROWS, Runner, frozen, text_tree, whole_numbers
from lwr_dyn.kinematics.closed_forms.texts import ANGLE_NUMBERS, closed_form_text

GIVEN = 20
"""Numbers that a function can be given: a pose, and what else it asks for."""

_WRITERS = (("lwr_dyn.kinematics.closed_forms", "text_parser.py"), ("lwr_dyn.codegen.kernels", "llvm_text.py"))
"""The cache does not keep what an earlier version of these has made."""


def written(texts: tuple[str, ...], numbers: Mapping[str, Any], entry: str) -> str:
    """A function of the texts, with what it needs, in LLVM's language."""
    tree = text_tree(texts, whole_numbers(numbers), entry)
    return llvm_text(tree, ANGLE_NUMBERS, table_places(numbers), entry)


def _parts(texts: tuple[str, ...], numbers: Mapping[str, Any]) -> list[str]:
    """All on which the machine code depends, but the entry, the processor and LLVM."""
    writers = [(files(package) / name).read_text(encoding="utf-8") for package, name in _WRITERS]
    layout = [f"{name} {place}" for name, place in table_places(numbers).items()]
    sources = [closed_form_text("own_angles", *texts), repr(whole_numbers(numbers)), repr(ANGLE_NUMBERS)]
    return [*writers, *sources, *layout]


def machine_code(texts: tuple[str, ...], numbers: Mapping[str, Any], entry: str = ENTRY) -> bytes:
    """Object code of the texts with the function `kernel`, for this processor."""
    module = llvm.parse_assembly(DECLARATIONS + written(texts, numbers, entry))
    optimise(module)
    code: bytes = target_machine().emit_object(module)
    return code


def kept_machine_code(texts: tuple[str, ...], numbers: Mapping[str, Any], entry: str = ENTRY) -> LoadedCode:
    """The function of these texts: of this process, from the cache, or compiled now."""
    key = cache_name("branches", [*_parts(texts, numbers), entry, *host_cpu(), version("llvmlite")])
    code: LoadedCode = kept_code(key, lambda: machine_code(texts, numbers, entry), 1)
    return code


class _CallRoom(threading.local):
    """Room for one call of a thread, at the same addresses every time."""

    def __init__(self, size: int, numbers: Array) -> None:
        self.given, self.out = np.zeros(GIVEN), np.zeros(size)
        self.pose = self.given[:16].reshape(4, 4)
        self.call = (address(self.given), 0, address(self.out), address(numbers), 0, 0)


def ctypes_runner(texts: tuple[str, ...], numbers: Mapping[str, Any]) -> Runner:
    """As `compiled_runner`, on every machine."""
    code, size, arm = kept_machine_code(texts, numbers), int(numbers["SIZE"]), table(numbers)
    room, function = _CallRoom(size, arm), code.call
    of_rows, width = kept_machine_code(texts, numbers, ROWS).call, numbers["JOINTS"] + 3

    def run(pose: Array, *more: float) -> Array | None:
        room.pose[:] = pose
        if more:
            room.given[16 : 16 + len(more)] = more
        return None if function(*room.call) else room.out.copy()

    def rows_of(out: Array, count: int) -> Array:
        rows = np.empty((2 * count, width))
        of_rows(address(out), 0, address(rows), address(arm), 0, 0)
        return frozen(rows[:count])

    return Runner(run, rows_of)


_WITH_MORE = """
declare void @llvm.memcpy.p0.p0.i64(ptr, ptr, i64, i1)
define internal double @body(ptr %numbers, ptr %pose, double %psi, double %margin, ptr %out) {{
  %given = alloca [{given} x double]
  call void @llvm.memcpy.p0.p0.i64(ptr %given, ptr %pose, i64 128, i1 false)
  %psi.p = getelementptr double, ptr %given, i64 16
  store double %psi, ptr %psi.p
  %margin.p = getelementptr double, ptr %given, i64 17
  store double %margin, ptr %margin.p
  %r = call i64 @{entry}(ptr %numbers, ptr %given, ptr %out)
  %flag = sitofp i64 %r to double
  ret double %flag
}}
"""

_WITH_ONE = """
define internal double @body(ptr %numbers, ptr %given, ptr %out) {{
  %r = call i64 @{entry}(ptr %numbers, ptr %given, ptr %out)
  %flag = sitofp i64 %r to double
  ret double {flag}
}}
"""


def compiled_runner(texts: tuple[str, ...], numbers: Mapping[str, Any]) -> Runner:
    """The row "compiled" of `RUNNERS`."""
    if closed_because():
        return ctypes_runner(texts, numbers)
    arm, size, parts = table(numbers), int(numbers["SIZE"]), [*_parts(texts, numbers), _WITH_MORE, _WITH_ONE]
    joints, has_more = int(numbers["JOINTS"]), "ARM_ANGLE" in numbers

    def body(entry: str, text: str, flag: str) -> str:
        return written(texts, numbers, entry) + text.format(given=GIVEN, entry=entry, flag=flag)

    def behind(arm: Array, pose: Array, *more: float) -> Array | None:
        plain = np.require(pose, np.float64, ["C", "A", "E"])
        return None if plain is pose else call(arm, plain, *more)

    signature = Signature(((len(arm),), (4, 4), *[()] * (2 * has_more)), (size,))
    text = partial(body, ENTRY, _WITH_MORE if has_more else _WITH_ONE, "%flag")
    call = single_call(ENTRY, signature, parts, text, behind, optimised=True)
    signature = Signature(((len(arm),), (size,), (None, joints + 3)), None)
    of_rows = single_call(ROWS, signature, parts, partial(body, ROWS, _WITH_ONE, "0.0"), _not_rows, optimised=True)

    def rows_of(out: Array, count: int) -> Array:
        rows = np.empty((2 * count, joints + 3))
        of_rows(arm, out, rows)
        return frozen(rows[:count])

    return Runner(partial(call, arm), rows_of)


def _not_rows(*given: Any) -> None:
    raise TypeError(f"not arrays of a closed form: {given!r}")
