"""Generates the Python source of the scalar kernel that keeps every sample of one run, for `compiled_loop`."""

from collections.abc import Sequence
from dataclasses import dataclass

from lwr_dyn.codegen.rollouts.slots import Slots
from lwr_dyn.codegen.rollouts.step import GENERATOR, StepPlan, steps
from lwr_dyn.codegen.rollouts.step_source import body_text, row_width
from lwr_dyn.foundation.version import VERSION

INPUTS = ("common", "reference")
BEFORE, AFTER = ("q", "dq", "memory"), ("command", "applied", "friction_torque", "friction_work")
"""What is kept of a sample, in this order: before the step, and what the step made of it."""

_SOURCE = '''"""One run of {name} under {law}, sample by sample: {operations} operations a step.

Written by lwr_dyn {version}, generator {generator}.
"""

from numba import carray, cfunc, types

from lwr_dyn.codegen.kernels.lowering import straight_line

{bodies}

number, count = types.CPointer(types.float64), types.int64


@cfunc(count(number, count, number, count, number, number, count, count), error_model="numpy")
def kernel(common_, common_n, reference_, samples, out_, b_, start, stop):
    """Samples start to stop; the block keeps the state between two calls."""
    common, b = carray(common_, ({size},), types.float64), carray(b_, ({size} + 1,), types.float64)
    reference = carray(reference_, (samples * {row},), types.float64)
    out = carray(out_, (samples * {width},), types.float64)
    if start == 0:
        for j in range({size}):
            b[j] = common[j]
    for i in range(start, stop):
        for j in range({row}):
            b[{row_first} + j] = reference[i * {row} + j]
        b[{sample}] = i
{before}
{step}
{after}
    return 0
'''


@dataclass(frozen=True, slots=True)
class WholeSource:
    """The Python text of a kernel, and where each kept name stands in a row of its results."""

    text: str
    columns: dict[str, slice]


def kept_columns(slots: Slots) -> dict[str, slice]:
    """Where each kept name stands in a row."""
    out, first = {}, 0
    for name in (*BEFORE, *AFTER):
        out[name] = slice(first, first + slots.widths[name])
        first += slots.widths[name]
    return out


def whole_source(plan: StepPlan) -> WholeSource:
    """The source of the scalar kernel of a plan with `whole`."""
    slots, columns = plan.slots, kept_columns(plan.slots)
    parts = [body_text(plan, step, name, 1) for step, name in zip(steps(plan), ("body", "motion"), strict=False)]
    calls = ["body(b)"] + [f"for _ in range({plan.substeps}):", "    motion(b)"] * (len(parts) > 1)
    width = columns[AFTER[-1]].stop
    text = _SOURCE.format(
        name=f"{plan.plant.name} ({plan.plant.reading})", law=plan.form.name, version=VERSION, generator=GENERATOR,
        operations=sum(part[1] for part in parts), bodies="\n\n".join(part[0] for part in parts), size=slots.size,
        row=row_width(plan), width=width, row_first=slots.first("reference"), sample=slots.first("sample"),
        step="\n".join(" " * 8 + call for call in calls), before=_kept(slots, columns, BEFORE, width),
        after=_kept(slots, columns, AFTER, width),
    )  # fmt: skip
    return WholeSource(text, columns)


def _kept(slots: Slots, columns: dict[str, slice], names: Sequence[str], width: int) -> str:
    """Copies from the block to a row."""
    lines = []
    for name in names:
        if slots.widths[name]:
            lines += [
                f"        for j in range({slots.widths[name]}):",
                f"            out[i * {width} + {columns[name].start} + j] = b[{slots.first(name)} + j]",
            ]
    return "\n".join(lines)
