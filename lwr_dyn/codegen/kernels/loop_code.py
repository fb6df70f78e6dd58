"""The loop of a kernel, a text in the small part of C, and what it calls: one module of LLVM, then machine code.

A loop calls bodies, which are straight-line code on vectors, and helpers, such as transposes. Helpers are put in where
they are called and optimised with the loop; bodies, thousands of instructions in the best order already, are left as
they are.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from llvmlite import binding as llvm

from lwr_dyn.codegen.kernels.llvm_text import DECLARATIONS, llvm_functions
from lwr_dyn.codegen.kernels.loop_helpers import Helper
from lwr_dyn.codegen.kernels.lowering import body_assembly
from lwr_dyn.codegen.kernels.machine_code import machine_code, optimise
from lwr_dyn.kinematics.closed_forms import tree

_KINDS = {"double*": "ptr", "int": "i64"}


@dataclass(frozen=True, slots=True)
class LaneBody:
    """Straight-line code, as `lowering` takes it, that a loop calls by its name: (b), or (b, out, at)."""

    name: str
    text: str
    is_streaming: bool = False

    @property
    def has_results(self) -> bool:
        """Whether results go to rows or blocks of `out`, from place `at` on."""
        return "(b, out, at)" in self.text

    @property
    def heading(self) -> tree.CFunction:
        """As the loop sees it."""
        more = (("double*", "out"), ("int", "at")) if self.has_results else ()
        return tree.CFunction(self.name, "void", (("double*", "b"), *more), ())


@dataclass(frozen=True, slots=True)
class KernelLoop:
    """A loop in C, of which `kernel` has the arguments and the result of the function `entry`, and what it calls."""

    text: tree.CText
    entry: str
    bodies: tuple[LaneBody, ...]
    helpers: tuple[Helper, ...] = ()
    constants: Mapping[str, float] = field(default_factory=dict)
    dtype: str = "float64"
    """Of all its numbers. A loop of float32 copies and compares: constants and functions are those of float64."""

    def assembly(self) -> str:
        """The loop as an LLVM module, without what it calls."""
        (function,) = (each for each in self.text.functions if each.name == self.entry)
        arguments = ", ".join(f"{_KINDS[kind]} %{name}" for kind, name in function.arguments)
        others = [*(body.heading for body in self.bodies), *(each.heading for each in self.helpers)]
        parts = [
            DECLARATIONS if self.dtype == "float64" else "",
            llvm_functions(self.text, self.constants, {}, others),
            *(_declared(each.heading) for each in self.helpers),
            *map(_around, self.bodies),
            f"define i64 @kernel({arguments}) {{",
            f"  %r = call i64 @{self.entry}(ptr null, {arguments})\n  ret i64 %r\n}}\n",
        ]
        text = "\n".join(parts)
        return text if self.dtype == "float64" else re.sub(r"\bdouble\b", "float", text)

    def machine_code(self) -> bytes:
        """Object code for this processor of the loop and all that it calls."""
        module = llvm.parse_assembly(self.assembly())
        for each in self.helpers:
            module.link_in(llvm.parse_assembly(each.assembly))
        _hide(module)
        optimise(module)
        for body in self.bodies:
            assembly = body_assembly(body.text, f"{body.name}_code", self.dtype, body.is_streaming)
            module.link_in(llvm.parse_assembly(assembly))
        _hide(module)
        return machine_code(module)


def _hide(module: Any) -> None:
    """Only `kernel` can be called from outside; what others could call counts as far away."""
    for function in module.functions:
        if not function.is_declaration and function.name != "kernel":
            function.linkage = "internal"


def _declared(heading: tree.CFunction) -> str:
    kind = {"void": "void", "int": "i64"}[heading.kind]
    return f"declare {kind} @{heading.name}({', '.join(['ptr', *(_KINDS[each] for each, _ in heading.arguments)])})"


def _around(body: LaneBody) -> str:
    """The body without the table of numbers that stands in front of the arguments of a text's functions."""
    if not body.has_results:
        return f"""declare void @{body.name}_code(ptr)
define internal void @{body.name}(ptr %numbers, ptr %b) alwaysinline {{
  call void @{body.name}_code(ptr %b)
  ret void
}}"""
    return f"""declare void @{body.name}_code(ptr, ptr)
define internal void @{body.name}(ptr %numbers, ptr %b, ptr %out, i64 %at) alwaysinline {{
  %place = getelementptr double, ptr %out, i64 %at
  call void @{body.name}_code(ptr %b, ptr %place)
  ret void
}}"""
