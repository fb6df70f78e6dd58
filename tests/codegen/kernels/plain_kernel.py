"""Kernels run by Python: the very text that LLVM compiles, over all states at once, so that formulas need no compiler.

What it leaves out is what is made of the text, and the transposes around it: `test_kernel_source` compares machine code
with it, function by function.
"""

import ctypes
import re
from contextlib import contextmanager

import numpy as np
import pytest

from lwr_dyn.codegen.kernels.kernel_source import generate

_CHOICE = re.compile(r"(v\d+) = (.+) if (.+) else (.+)")


def body_of(text):
    """`body(b, out, at, where)` of a kernel's text for the first lane; choices are made by `where`."""
    loop = text[text.index("    for k in range(") :]
    lines = [_CHOICE.sub(r"\1 = where(\3, \2, \4)", line.strip()) for line in loop.splitlines()[1:]]
    names = {"sqrt": np.sqrt, "abs": np.abs, "fma": lambda x, y, z: x * y + z}
    exec("\n ".join(["def body(b, out, at, where, k=0):", *(line for line in lines if line)]), names)
    return names["body"]


class PlainKernel:
    """What `kernel_of` gives for a spec with rows of results, in place of machine code."""

    def __init__(self, spec, function):
        assert spec.layout == "rows"
        source = generate(spec, function)
        self.interface, self.dtype, self._body = source.interface, np.dtype(spec.dtype), body_of(source.body)

    def run(self, rows, out, count, threads=1):
        """As `Kernel.run`: `count` rows from addresses and steps; the number of states whose results are invalid."""
        face = self.interface
        given = np.concatenate(
            [self._memory(*row, count, width) for row, width in zip(rows, face.widths, strict=True)], axis=1
        )
        b, results = [None] * face.buffer, [None] * face.width
        b[: given.shape[1] * face.lanes : face.lanes] = given.T
        with np.errstate(all="ignore"):
            self._body(b, results, 0, self._where)
        for place, result in zip(self._memory(out, face.width, count, face.width).T, results, strict=True):
            place[:] = result
        flag = b[given.shape[1] * face.lanes]
        return int(np.sum(np.broadcast_to(flag, count) != 0.0))

    def _where(self, test, yes, no):
        return np.where(test, yes, no).astype(self.dtype)

    def _memory(self, address, step, count, width):
        """The numbers there, (count, width)."""
        kind = np.ctypeslib.as_ctypes_type(self.dtype)
        flat = np.ctypeslib.as_array(ctypes.cast(address, ctypes.POINTER(kind)), ((count - 1) * step + width,))
        size = self.dtype.itemsize
        return np.lib.stride_tricks.as_strided(flat, (count, width), (step * size, size))


@contextmanager
def kernels_by_python():
    """Within it batches and the engine "kernels" that have compiled nothing yet run the text of their kernels."""
    known = {}

    def kernel_of(spec, function):
        key = (spec.digest(function), function)
        return known.get(key) or known.setdefault(key, PlainKernel(spec, function))

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("lwr_dyn.codegen.kernels.batch.kernel_of", kernel_of)
        yield
