"""Functions that the loop of a kernel calls, written with LLVM's builder and put in where they are called."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from llvmlite import ir

from lwr_dyn.kinematics.closed_forms import tree


@dataclass(frozen=True, slots=True)
class Helper:
    """A function in LLVM's language that a loop calls; its first argument is not used."""

    heading: tree.CFunction
    assembly: str


def helper(
    name: str,
    kind: str,
    arguments: Sequence[tuple[str, str]],
    number: Any,
    write: Callable[[Any, Sequence[Any]], Any],
) -> Helper:
    """A helper that `write` (builder, arguments) writes; numbers of its arrays are of LLVM's type `number`.

    `kind` is "void" or "int"; `arguments` are pairs of "double*" or "int" and a name.
    """
    module, whole = ir.Module(name), ir.IntType(64)
    kinds = {"double*": number.as_pointer(), "int": whole, "void": ir.VoidType()}
    given = [ir.IntType(8).as_pointer(), *(kinds[each] for each, _ in arguments)]
    function = ir.Function(module, ir.FunctionType(kinds[kind], given), name)
    function.attributes.add("alwaysinline")
    builder = ir.IRBuilder(function.append_basic_block())
    result = write(builder, function.args[1:])
    if kind == "void":
        builder.ret_void()
    else:
        builder.ret(builder.zext(result, whole))
    return Helper(tree.CFunction(name, kind, tuple(arguments), ()), str(module))
