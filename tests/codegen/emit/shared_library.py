"""Emitted C functions of an arm as a shared library, called with NumPy arrays and numbers."""

import ctypes
from pathlib import Path
from typing import Any

import numpy as np

from lwr_dyn.codegen.emit.c_file import c_files
from lwr_dyn.codegen.emit.emission import EmittedArm
from tests.codegen.emit.programs import shared

WARNINGS = ("-std=c99", "-Wall", "-Wextra", "-Wconversion", "-Werror")
_KINDS = {"float64": ctypes.c_double, "int32": ctypes.c_int}


class SharedLibrary:
    """The functions of an arm."""

    def __init__(self, emitted: EmittedArm, folder: Path, level: str = "-O1") -> None:
        for path, text in c_files(emitted, folder / "arm.c").items():
            path.write_text(text)
        self.arm, self.emitted, self.library = emitted.arm, emitted, shared(folder, ["arm.c"], level, *WARNINGS)

    def call(self, name: str, *arguments: Any, kind: Any = ctypes.c_double) -> Any:
        """Call a function: numbers are double, arrays double or int."""
        function = getattr(self.library, self.emitted.name_of(name))
        function.restype = kind
        return function(*(ctypes.c_double(x) if isinstance(x, float) else _pointer(x) for x in arguments))


def _pointer(array: np.ndarray) -> Any:
    assert array.flags.c_contiguous
    return array.ctypes.data_as(ctypes.POINTER(_KINDS[str(array.dtype)]))
