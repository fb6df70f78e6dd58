"""One state at a time: functions that Python calls as it calls C, in a fifth of a microsecond.

The machine code reads the arrays where they lie: float64 in this machine's order of bytes, of exactly the right shape,
dense, aligned, and `numpy.ndarray` itself. It gives a new array or a float. All other arguments, another number of
them, and a state whose flag is not zero (not finite, or an angle too large) go to the Python function behind it, which
checks them and says what is wrong; so nothing is refused or computed here that is not there.

Where that road is closed (`closed_because`), the function behind it serves alone.
"""

import ctypes
import math
import platform
import sys
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, partial
from importlib import import_module
from typing import Any

import numpy as np

from lwr_dyn.codegen.kernels.kernel import MAKERS, cache_name, read_cache, write_cache
from lwr_dyn.codegen.kernels.scalar_code import DECLARATIONS
from lwr_dyn.foundation.version import package_version

Call = Callable[..., Any]

_TYPE, _DATA, _AXES, _SHAPE, _STRIDES, _DTYPE, _FLAGS = 8, 16, 24, 32, 40, 56, 64
"""Where an array's object holds these, fixed in NumPy's ABI (PyArrayObject_fields), on a Python with a lock; a float
has its number where an array has its data."""
_BYTE_ORDER, _NUMBER_TYPE = 26, 28
"""The same of its dtype (PyArray_Descr); `=` is this machine's order, 12 is NPY_DOUBLE."""
_ALIGNED, _WRITEABLE, _DOUBLE = 0x100, 0x400, 12
_ARRAY_NEW = 93
"""The place of PyArray_New in NumPy's table of functions."""
_FAST_CALL = 0x80
"""METH_FASTCALL."""


@cache
def closed_because() -> str:
    """Why single states are not called at C level here; empty where they are.

    Offsets of objects are those of 64-bit CPython with the interpreter's lock; the code was tried on x86-64 alone.
    """
    if sys.implementation.name != "cpython" or object.__basicsize__ != 16:
        return "not a 64-bit CPython with the interpreter's lock"
    if platform.machine().lower() not in ("x86_64", "amd64") or sys.platform != "linux":
        return f"not tried on {sys.platform} on {platform.machine()}"
    if not _layout_holds(np.arange(3.0)):
        return f"NumPy {np.__version__} lays its arrays out in another way"
    return ""


def _layout_holds(x: Any) -> bool:
    """Whether an array (k,) of float64 holds its parts where they are looked for."""

    def at(place: int, kind: Any) -> Any:
        return kind.from_address(place).value

    place, word = id(x), ctypes.c_void_p
    dtype = at(place + _DTYPE, word)
    found = (
        at(place + _TYPE, word), at(place + _DATA, word), at(place + _AXES, ctypes.c_int),
        at(at(place + _SHAPE, word), ctypes.c_int64), at(at(place + _STRIDES, word), ctypes.c_int64), dtype,
        at(place + _FLAGS, ctypes.c_int) & (_ALIGNED | _WRITEABLE), at(dtype + _NUMBER_TYPE, ctypes.c_int),
        at(dtype + _BYTE_ORDER, ctypes.c_char),
    )  # fmt: skip
    data = x.__array_interface__["data"][0]
    return found == (id(np.ndarray), data, 1, len(x), 8, id(x.dtype), _ALIGNED | _WRITEABLE, _DOUBLE, b"=")


@dataclass(frozen=True, slots=True)
class Signature:
    """What a function of single states takes: the shape of each argument, () a float of Python itself.

    It gives a new array of shape `result`, a float of shape (), or None where it is None: the last argument is then
    written to.
    """

    arguments: tuple[tuple[int | None, ...], ...]
    """A length of None, of the first axis, is any."""
    result: tuple[int, ...] | None


_TEXT = """
{declarations}
declare ptr @lwr_dyn_call(ptr, ptr, i64, ptr)
declare ptr @lwr_dyn_new_array(ptr, i32, ptr, i32, ptr, ptr, i32, i32, ptr)
declare ptr @lwr_dyn_new_float(double)
declare void @lwr_dyn_keep(ptr)
declare void @lwr_dyn_release(ptr)
@lwr_dyn_array = external global i8
@lwr_dyn_float = external global i8
@lwr_dyn_none = external global i8
@shape = private constant [{axes} x i64] [{shape}]

{body}

define ptr @single(ptr %self, ptr %given, i64 %count) {{
  %is.count = icmp eq i64 %count, {count}
  br i1 %is.count, label %check0, label %behind
{checks}
compute:
{give}
behind:
  %other = call ptr @lwr_dyn_call(ptr %self, ptr %given, i64 %count, ptr null)
  ret ptr %other
nothing:
  ret ptr null
}}
"""

_GIVE = {
    "array": """  %array = call ptr @lwr_dyn_new_array(ptr @lwr_dyn_array, i32 {axes}, ptr @shape, i32 12, ptr null,
    ptr null, i32 0, i32 0, ptr null)
  %is.none = icmp eq ptr %array, null
  br i1 %is.none, label %nothing, label %work
work:
  %out.p = getelementptr i8, ptr %array, i64 16
  %out = load ptr, ptr %out.p
  %flag = call double @body({given}, ptr %out)
  %is.good = fcmp oeq double %flag, 0.0
  br i1 %is.good, label %good, label %bad
good:
  ret ptr %array
bad:
  call void @lwr_dyn_release(ptr %array)
  br label %behind""",
    "float": """  %out = alloca double
  %flag = call double @body({given}, ptr %out)
  %is.good = fcmp oeq double %flag, 0.0
  br i1 %is.good, label %good, label %behind
good:
  %result = load double, ptr %out
  %float = call ptr @lwr_dyn_new_float(double %result)
  ret ptr %float""",
    "none": """  %flag = call double @body({given})
  %is.good = fcmp oeq double %flag, 0.0
  br i1 %is.good, label %good, label %behind
good:
  call void @lwr_dyn_keep(ptr @lwr_dyn_none)
  ret ptr @lwr_dyn_none""",
}


def module_text(signature: Signature, body: str) -> str:
    """LLVM's text of a module.

    `body` defines `double @body(ptr each argument, ptr result)`, a double for each float, which gives 0.0 where its
    results hold. Without a result of its own it must not have written to the last argument where they do not.
    """
    arguments, result = signature.arguments, signature.result
    kind = "none" if result is None else "array" if result else "float"
    shape, last = result or (0,), len(arguments) - 1
    given = ", ".join(f"{'ptr' if each else 'double'} %data{i}" for i, each in enumerate(arguments))
    checks = [
        line
        for i, each in enumerate(arguments)
        for line in _check(i, each, f"check{i + 1}" if i < last else "compute", kind == "none" and i == last)
    ]
    return _TEXT.format(
        declarations=DECLARATIONS, axes=len(shape), shape=", ".join(f"i64 {x}" for x in shape), body=body,
        count=len(arguments), checks="\n".join(checks), give=_GIVE[kind].format(axes=len(shape), given=given),
    )  # fmt: skip


def _check(i: int, shape: Sequence[int | None], after: str, is_written: bool) -> list[str]:
    """Blocks that lead to `after` where argument i is as it must be, and to %behind where it is not."""
    if not shape:
        return _float_check(i, after)
    need = _ALIGNED | (_WRITEABLE if is_written else 0)
    lines = [f"check{i}:", f"  %g{i} = getelementptr ptr, ptr %given, i64 {i}", f"  %a{i} = load ptr, ptr %g{i}"]
    lines += _field(i, "type", "ptr", f"a{i}", _TYPE) + _branch(i, 0, [("type", "ptr", "@lwr_dyn_array")])
    lines += _field(i, "axes", "i32", f"a{i}", _AXES) + _field(i, "flags", "i32", f"a{i}", _FLAGS)
    lines += [f"  %need{i} = and i32 %flags{i}, {need}", *_field(i, "dtype", "ptr", f"a{i}", _DTYPE)]
    lines += _field(i, "number", "i32", f"dtype{i}", _NUMBER_TYPE) + _field(i, "order", "i8", f"dtype{i}", _BYTE_ORDER)
    wanted = [("axes", "i32", len(shape)), ("need", "i32", need), ("number", "i32", _DOUBLE), ("order", "i8", ord("="))]
    lines += _branch(i, 1, wanted)
    lines += _field(i, "shape", "ptr", f"a{i}", _SHAPE) + _field(i, "strides", "ptr", f"a{i}", _STRIDES)
    lengths = []
    for axis, length in enumerate(shape):
        inner = math.prod(x or 0 for x in shape[axis + 1 :])
        for name, value in (("shape", length), ("strides", 8 * inner)):
            lines += _field(i, f"{name}.{axis}.", "i64", f"{name}{i}", 8 * axis)
            lengths += [] if value is None else [(f"{name}.{axis}.", "i64", value)]
    return lines + _field(i, "data", "ptr", f"a{i}", _DATA) + _branch(i, 2, lengths, after)


def _float_check(i: int, after: str) -> list[str]:
    """As `_check`, of a float."""
    lines = [f"check{i}:", f"  %g{i} = getelementptr ptr, ptr %given, i64 {i}", f"  %a{i} = load ptr, ptr %g{i}"]
    lines += _field(i, "type", "ptr", f"a{i}", _TYPE) + _branch(i, 0, [("type", "ptr", "@lwr_dyn_float")])
    return [*lines, *_field(i, "data", "double", f"a{i}", _DATA), f"  br label %{after}"]


def _field(i: int, name: str, kind: str, of: str, offset: int) -> list[str]:
    """%name<i>, of a kind, that lies in the object %of."""
    at = f"%{name}{i}.at"
    return [f"  {at} = getelementptr i8, ptr %{of}, i64 {offset}", f"  %{name}{i} = load {kind}, ptr {at}"]


def _branch(i: int, step: int, wanted: Sequence[tuple[str, str, object]], after: str = "") -> list[str]:
    """On to the next block, or to `after`, where every %name<i> is what is wanted; else to %behind."""
    lines, all_good = [], "true"
    for k, (name, kind, value) in enumerate(wanted):
        lines += [f"  %is{i}.{step}.{k} = icmp eq {kind} %{name}{i}, {value}"]
        lines += [f"  %and{i}.{step}.{k} = and i1 {all_good}, %is{i}.{step}.{k}"]
        all_good = f"%and{i}.{step}.{k}"
    lines += [f"  br i1 {all_good}, label %{after or f'block{i}.{step}'}, label %behind"]
    return lines if after else [*lines, f"block{i}.{step}:"]


class _Method(ctypes.Structure):
    """PyMethodDef."""

    _fields_ = (("name", ctypes.c_char_p), ("code", ctypes.c_void_p), ("flags", ctypes.c_int), ("doc", ctypes.c_char_p))


_engines: dict[str, Any] = {}
_loading = threading.Lock()


def single_call(
    name: str,
    signature: Signature,
    parts: Sequence[str],
    body: Callable[[], str],
    behind: Call,
    doc: str = "",
    *,
    optimised: bool = False,
) -> Call:
    """The function of single states with that signature; what its code does not take goes to `behind`.

    Parameters
    ----------
    name : str
        Of the function, as Python shows it.
    signature : Signature
    parts : sequence of str
        All on which the body depends.
    body : callable
        Gives the text for `module_text`; called when no code is kept.
    behind : callable
        Takes the same arguments. It is returned itself where `closed_because` says why.
    optimised : bool
        Through the passes of LLVM too, for a body with loops and calls; straight lines are taken as they are written.
    """
    if closed_because():
        return behind
    from lwr_dyn.codegen.kernels.machine_code import host_cpu

    key = cache_name(f"single-{name}", [*parts, repr(signature), *host_cpu(), *map(package_version, MAKERS)])
    with _loading:
        if key not in _engines:
            _engines[key] = _engine(_code(key, signature, body, optimised))
    place = _engines[key].get_function_address("single")
    kept: Any = partial(behind)
    kept.memory = _engines[key], _Method(name.encode(), place, _FAST_CALL, doc.encode())
    make = ctypes.pythonapi.PyCFunction_NewEx
    make.restype, make.argtypes = ctypes.py_object, [ctypes.c_void_p, ctypes.py_object, ctypes.c_void_p]
    call: Call = make(ctypes.addressof(kept.memory[1]), kept, None)
    return call  # its `self` is `kept`, and so keeps the memory in which its code and its name lie


def _code(key: str, signature: Signature, body: Callable[[], str], optimised: bool) -> bytes:
    """The object code of that key: kept, or made now."""
    from llvmlite import binding as llvm

    from lwr_dyn.codegen.kernels.machine_code import optimise, target_machine

    known = read_cache(key)
    if known is not None:
        return known[1]
    module = llvm.parse_assembly(module_text(signature, body()))
    if optimised:
        optimise(module)
    code: bytes = target_machine().emit_object(module)
    write_cache(key, {}, code)
    return code


def _engine(code: bytes) -> Any:
    """The memory with the code, ready to be called."""
    from llvmlite import binding as llvm

    from lwr_dyn.codegen.kernels.machine_code import target_machine

    _tell_addresses()
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), target_machine(), None)
    engine.add_object_file(llvm.ObjectFileRef.from_data(code))
    engine.finalize_object()
    return engine


@cache
def _tell_addresses() -> None:
    """Tells LLVM where Python's and NumPy's functions and objects are."""
    from llvmlite import binding as llvm

    umath: Any = import_module("numpy._core._multiarray_umath")
    python = ctypes.pythonapi
    pointer = python.PyCapsule_GetPointer
    pointer.restype, pointer.argtypes = ctypes.c_void_p, [ctypes.py_object, ctypes.c_char_p]
    numpy = ctypes.cast(pointer(umath._ARRAY_API, None), ctypes.POINTER(ctypes.c_void_p))
    functions = {
        "call": python.PyObject_Vectorcall, "new_float": python.PyFloat_FromDouble, "keep": python.Py_IncRef,
        "release": python.Py_DecRef,
    }  # fmt: skip
    addresses = {name: ctypes.cast(function, ctypes.c_void_p).value for name, function in functions.items()}
    addresses |= {"new_array": numpy[_ARRAY_NEW], "array": id(np.ndarray), "float": id(float), "none": id(None)}
    for name, address in addresses.items():
        llvm.add_symbol(f"lwr_dyn_{name}", address)
