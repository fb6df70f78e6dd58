"""The processor kernels are compiled for, and machine code as a function that can be called."""

from __future__ import annotations

import ctypes
import functools
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from llvmlite import binding as llvm

VECTOR_BYTES_WIDE, VECTOR_BYTES = 64, 32


@functools.cache
def host() -> tuple[str, str, str]:
    """Platform, processor and its features, as LLVM names them."""
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    return llvm.get_process_triple(), llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten()


def lanes_of(dtype: str) -> int:
    """States of a block: what one vector register of this machine holds."""
    wide = "+avx512f" in host()[2].split(",")
    return (VECTOR_BYTES_WIDE if wide else VECTOR_BYTES) // (8 if dtype == "float64" else 4)


def target_machine() -> Any:
    """The compiler's back end for this processor."""
    triple, name, features = host()
    target = llvm.Target.from_triple(triple)
    return target.create_target_machine(cpu=name, features=features, opt=3, jit=True)


@dataclass(frozen=True, slots=True, eq=False)
class LoadedCode:
    """Machine code in memory: `call` takes pairs of address and step, then result, buffer, start and stop."""

    call: Callable[..., int]
    engine: Any
    """Owns the memory."""


def load(code: bytes, name: str, inputs: int) -> LoadedCode:
    """An object file's function `name` of so many inputs, ready to be called (without the interpreter's lock)."""
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), target_machine())
    engine.add_object_file(llvm.ObjectFileRef.from_data(code))
    engine.finalize_object()
    pairs = [ctypes.c_void_p, ctypes.c_int64] * inputs
    signature = ctypes.CFUNCTYPE(ctypes.c_int64, *pairs, *[ctypes.c_void_p] * 2, *[ctypes.c_int64] * 2)
    return LoadedCode(signature(engine.get_function_address(name)), engine)
