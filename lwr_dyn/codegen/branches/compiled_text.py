"""The text of a closed form as a function in memory: of this process, from the cache, or compiled now by LLVM alone."""

import threading
from collections.abc import Mapping
from importlib.metadata import version
from importlib.resources import files
from typing import Any

import numpy as np
from llvmlite import binding as llvm

from lwr_dyn.codegen.branches.llvm_text import llvm_text, table, table_places
from lwr_dyn.codegen.kernels.kernel import address, cache_name, read_cache, write_cache
from lwr_dyn.codegen.kernels.machine_code import LoadedCode, host_cpu, load, target_machine
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.kinematics.closed_forms.runners import ENTRY, Runner, text_tree, whole_numbers
from lwr_dyn.kinematics.closed_forms.texts import ANGLE_NUMBERS, closed_form_text

GIVEN = 20
"""Numbers that a function can be given: a pose, and what else it asks for."""

_WRITERS = (("lwr_dyn.kinematics.closed_forms", "text_parser.py"), ("lwr_dyn.codegen.branches", "llvm_text.py"))
"""The cache does not keep what an earlier version of these has made."""

_codes: dict[str, LoadedCode] = {}

_compiling = threading.Lock()


def machine_code(texts: tuple[str, ...], numbers: Mapping[str, Any]) -> bytes:
    """Object code of the texts with the function `kernel`, for this processor."""
    tree = text_tree(texts, whole_numbers(numbers))
    machine = target_machine()
    module = llvm.parse_assembly(llvm_text(tree, ANGLE_NUMBERS, table_places(numbers), ENTRY))
    builder = llvm.create_pass_builder(machine, llvm.create_pipeline_tuning_options(speed_level=2))
    builder.getModulePassManager().run(module, builder)
    code: bytes = machine.emit_object(module)
    return code


def kept_machine_code(texts: tuple[str, ...], numbers: Mapping[str, Any]) -> LoadedCode:
    """The function of these texts: of this process, from the cache, or compiled now."""
    written = [(files(package) / name).read_text(encoding="utf-8") for package, name in _WRITERS]
    layout = [f"{name} {place}" for name, place in table_places(numbers).items()]
    sources = [closed_form_text("own_angles", *texts), repr(whole_numbers(numbers)), repr(ANGLE_NUMBERS)]
    key = cache_name("branches", [*written, *sources, *layout, *host_cpu(), version("llvmlite")])
    with _compiling:
        if key not in _codes:
            kept = read_cache(key)
            code = machine_code(texts, numbers) if kept is None else kept[1]
            if kept is None:
                write_cache(key, {"symbol": "kernel"}, code)
            _codes[key] = load(code, "kernel", 1)
        return _codes[key]


class _CallRoom(threading.local):
    """Room for one call of a thread, at the same addresses every time."""

    def __init__(self, size: int, numbers: Array) -> None:
        self.given, self.out = np.zeros(GIVEN), np.zeros(size)
        self.pose = self.given[:16].reshape(4, 4)
        self.call = (address(self.given), 0, address(self.out), address(numbers), 0, 0)


def compiled_runner(texts: tuple[str, ...], numbers: Mapping[str, Any]) -> Runner:
    """The row "compiled" of `RUNNERS`."""
    code, size, numbers_of_arm = kept_machine_code(texts, numbers), int(numbers["SIZE"]), table(numbers)
    room, function = _CallRoom(size, numbers_of_arm), code.call

    def run(pose: Array, *more: float) -> Array | None:
        room.pose[:] = pose
        if more:
            room.given[16 : 16 + len(more)] = more
        return None if function(*room.call) else room.out.copy()

    return run
