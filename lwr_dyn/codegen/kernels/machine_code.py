"""From a module of LLVM to machine code for this processor, and machine code as a function to call."""

import ctypes
import functools
import struct
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from llvmlite import binding as llvm

VECTOR_BYTES_WIDE, VECTOR_BYTES = 64, 32


@functools.cache
def host_cpu() -> tuple[str, str, str]:
    """Platform, processor and its features, as LLVM names them."""
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    return llvm.get_process_triple(), llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten()


def lanes_of(dtype: str) -> int:
    """States in a block: the numbers that one vector register of this machine holds."""
    wide = "+avx512f" in host_cpu()[2].split(",")
    return (VECTOR_BYTES_WIDE if wide else VECTOR_BYTES) // (8 if dtype == "float64" else 4)


def fuses() -> bool:
    """Whether this processor multiplies and adds in one instruction; LLVM would call a library in place of it."""
    triple, _, features = host_cpu()
    return not triple.startswith(("x86_64", "i386", "i686")) or "+fma" in features.split(",")


def target_machine(near: bool = False) -> Any:
    """LLVM's back end for this processor; with `near`, one instruction finds a constant, within 32 bits of the code."""
    triple, name, features = host_cpu()
    target = llvm.Target.from_triple(triple)
    options = {"reloc": "pic", "codemodel": "small"} if near else {}
    return target.create_target_machine(cpu=name, features=features, opt=3, jit=True, **options)


def optimise(module: Any) -> None:
    """Runs LLVM's passes over a module; sums and products are not fused or put in another order by them."""
    builder = llvm.create_pass_builder(target_machine(), llvm.create_pipeline_tuning_options(speed_level=2))
    builder.getModulePassManager().run(module, builder)


_DISTANCE = 2
"""The ELF relocation of x86-64 by a distance of 32 bits."""


def _relocations(code: bytes) -> set[int]:
    """The kinds of places in the code that are filled in when it is loaded; of ELF alone."""
    sections = llvm.ObjectFileRef.from_data(code).sections()
    places = [section.data() for section in sections if section.name() in (b".rela.text", ".rela.text")]
    return {kind for data in places for _, kind, _, _ in struct.iter_unpack("<QIIq", data)}


def _is_near(code: bytes) -> bool:
    """Whether it finds all its constants within 32 bits and calls no other library."""
    return _relocations(code) == {_DISTANCE}


def machine_code(module: Any) -> bytes:
    """Object code of a module that calls nothing else; its constants are near unless it calls a library of LLVM's."""
    missing = [f.name for f in module.functions if f.is_declaration and not f.name.startswith("llvm.")]
    if missing:
        raise RuntimeError(f"a generated kernel calls {', '.join(missing)}: it must stand alone")
    if host_cpu()[0].startswith("x86_64") and "linux" in host_cpu()[0]:
        code: bytes = target_machine(near=True).emit_object(module)
        if _is_near(code):
            return code
    far: bytes = target_machine().emit_object(module)  # a library may be far away
    return far


@dataclass(frozen=True, slots=True, eq=False)
class LoadedCode:
    """Machine code in memory: `call` takes pairs of address and step, then result, buffer, start and stop."""

    call: Callable[..., int]
    engine: Any
    """Owns the memory."""


def load(code: bytes, name: str, inputs: int) -> LoadedCode:
    """Function `name` of an object file, with that number of inputs; calls run without the interpreter's lock."""
    in_one_piece = True if _is_near(code) else None  # by llvmlite's own memory manager
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), target_machine(), in_one_piece)
    engine.add_object_file(llvm.ObjectFileRef.from_data(code))
    engine.finalize_object()
    pairs = [ctypes.c_void_p, ctypes.c_int64] * inputs
    signature = ctypes.CFUNCTYPE(ctypes.c_int64, *pairs, *[ctypes.c_void_p] * 2, *[ctypes.c_int64] * 2)
    return LoadedCode(signature(engine.get_function_address(name)), engine)
