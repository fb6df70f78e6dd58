"""From a form to machine code: trace, write the source, let numba compile it, keep the object code."""

from __future__ import annotations

import itertools
import linecache
from typing import Any

import numpy as np
from llvmlite import binding as llvm

from lwr_dyn.codegen.form import Form
from lwr_dyn.codegen.machine import lanes_of, target_machine
from lwr_dyn.codegen.source import Source, source_of

_NUMBER = itertools.count()


def generate(form: Form, function: str, lanes: int | None = None) -> Source:
    """The source of a kernel: traced, simplified, written out. Raises `UnknownNameError` for another function."""
    from lwr_dyn.codegen.program import program_of
    from lwr_dyn.codegen.sincos import sincos
    from lwr_dyn.codegen.trace import trace

    numbers, traced = sincos(form.dtype), trace(form, function)
    widths = [traced.size1_in(i) for i in range(traced.n_in())]
    limit = (numbers.most_half_turns - 1) * np.pi / np.sqrt(max(form.n, 1))
    wide = lanes_of(form.dtype) if lanes is None else lanes
    return source_of(form, function, program_of(traced, numbers), widths, wide, float(limit))


def compiled(source: Source) -> tuple[bytes, str]:
    """Object code of a source and the name of its function."""
    file = f"<lwr_dyn kernel {next(_NUMBER)}>"
    linecache.cache[file] = (len(source.text), None, source.text.splitlines(keepends=True), file)
    names: dict[str, Any] = {"__name__": file}
    try:
        exec(compile(source.text, file, "exec"), names)
    finally:
        del linecache.cache[file]
    kernel = names["kernel"]
    machine = target_machine()
    module = llvm.parse_assembly(kernel.inspect_llvm())
    _only(module, kernel.native_name, machine)
    module.link_in(llvm.parse_assembly(names["body"].assembly))
    missing = [f.name for f in module.functions if f.is_declaration and not f.name.startswith("llvm.")]
    if missing:  # numba's helpers are not there when the code is loaded without numba
        raise RuntimeError(f"a generated kernel calls {', '.join(missing)}: it must stand alone")
    return machine.emit_object(module), kernel.native_name


def _only(module: Any, name: str, machine: Any) -> None:
    """Without what numba adds for Python callers and for errors that cannot happen: the code must stand alone."""
    for item in itertools.chain(module.functions, module.global_variables):
        if not item.is_declaration and item.name != name:
            item.linkage = "internal"
    builder = llvm.create_pass_builder(machine, llvm.create_pipeline_tuning_options(speed_level=2))
    passes = builder.getModulePassManager()
    passes.add_global_dead_code_eliminate_pass()
    passes.add_strip_dead_prototype_pass()
    passes.run(module, builder)
