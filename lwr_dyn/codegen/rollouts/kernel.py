"""A rollout kernel: the source of its driver over blocks of W runs, its machine code, and its runs over threads.

A block holds W lanes of every slot. Numbers of a run that are not given for each are copied from a common row, so the
same kernel serves whatever varies; the rows of a reference are shared, or picked lane by lane.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from lwr_dyn.codegen.kernels.elementary import sincos
from lwr_dyn.codegen.kernels.kernel import MAKERS, address, aligned, cache_name, kept_code, require_packages, shared_out
from lwr_dyn.codegen.kernels.kernel_source import placed_lines
from lwr_dyn.codegen.kernels.machine_code import host_cpu, lanes_of
from lwr_dyn.codegen.kernels.straight_line import straight_line_code
from lwr_dyn.codegen.rollouts.step import FIGURES, GENERATOR, SAMPLE, Slots, Step, StepPlan, steps
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.version import VERSION, package_version

INPUTS = ("common", "given", "places", "reference", "which", "record", "trace", "noise")
"""Pairs of an address and a number, in this order: the common row and whether runs are traced; values of each run and
how many; their slots and the number of samples; references and how many; the reference of each run and the record's
stride; the record and its samples; the squares of the tip's error; seed and number of the first run."""

_HEAD = '''"""Rollouts of {name} under {law}: {lanes} runs a block, {operations} operations a sample.

Written by lwr_dyn {version}, generator {generator}; {fused} operations with fused multiply-add.
"""

from numba import carray, cfunc, types

from lwr_dyn.codegen.kernels.lowering import straight_line
{imports}

{bodies}

number, count = types.CPointer(types.float64), types.int64


@cfunc(count({types}, number, number, count, count), error_model="numpy")
def kernel({arguments}, out_, b_, start, stop):
    """Runs start to stop; their figures go to rows of `out`."""
    values, samples, references, stride, kept = given_n, places_n, reference_n, which_n, record_n
    common, b = carray(common_, ({size},), types.float64), carray(b_, ({buffer},), types.float64)
    given, places = carray(given_, (stop * values + 1,), types.float64), carray(places_, (values + 1,), types.float64)
    reference = carray(reference_, (references * samples * {row},), types.float64)
    which, out = carray(which_, (stop,), types.float64), carray(out_, (stop * {figures},), types.float64)
    record = carray(record_, (stop * kept * {recorded} + 1,), types.float64)
    trace = carray(trace_, ((stop - start) * samples * common_n + 1,), types.float64)
    for s in range(start, stop, {lanes}):
        lanes = min({lanes}, stop - s)
        for j in range({size}):
            for k in range({lanes}):
                b[j * {lanes} + k] = common[j]
        for j in range(values):
            place = int(places[j]) * {lanes}
            for k in range({lanes}):
                b[place + k] = given[min(s + k, stop - 1) * values + j]
        for i in range(samples):
            if references == 1:
                for j in range({row}):
                    x = reference[i * {row} + j]
                    for k in range({lanes}):
                        b[({row_first} + j) * {lanes} + k] = x
            else:
                for k in range({lanes}):
                    row = (int(which[min(s + k, stop - 1)]) * samples + i) * {row}
                    for j in range({row}):
                        b[({row_first} + j) * {lanes} + k] = reference[row + j]
            for k in range({lanes}):
                b[{sample} + k] = i
            at = i // stride
            if kept != 0 and i % stride == 0:
                for k in range(lanes):
                    for j in range({state}):
                        record[((s + k) * kept + at) * {recorded} + j] = b[j * {lanes} + k]
{step}
            if kept != 0 and i % stride == 0:
                for k in range(lanes):
                    for j in range({joints}):
                        x = b[({applied} + j) * {lanes} + k]
                        record[((s + k) * kept + at) * {recorded} + {state} + j] = x
            if common_n != 0:
                for k in range(lanes):
                    trace[(s - start + k) * samples + i] = b[{tip_square} + k]
        for k in range(lanes):
            for j in range({figures}):
                out[(s + k) * {figures} + j] = b[({figures_first} + j) * {lanes} + k]
    return 0
'''

_BODY = """@straight_line("float64")
def {name}(b):
    for k in range({lanes}):
{lines}
"""


@dataclass(frozen=True, slots=True)
class RolloutSource:
    """The Python text of a rollout kernel, and its cost of a sample."""

    text: str
    operations: int
    fused: int


def rollout_source(plan: StepPlan, lanes: int) -> RolloutSource:
    """The source of a plan's kernel in blocks of `lanes` runs."""
    slots, names = plan.slots, ("body", "motion")
    n = plan.plant.n
    parts = [body_text(plan, step, name, lanes) for step, name in zip(steps(plan), names, strict=False)]
    calls = ["body(b)"] + [f"for _ in range({plan.substeps}):", "    motion(b)"] * (plan.substeps > 1)
    imports = ""
    if plan.noise == "philox":
        imports = "from lwr_dyn.codegen.rollouts.philox_code import uniform_code"
        fill = f"fill = uniform_code({lanes}, {slots.widths['chance']}, {slots.first('chance')})"
        calls = ["fill(b, noise_, noise_n + s, i)", *calls]
    whole = plan.substeps
    text = _HEAD.format(
        name=f"{plan.plant.name} ({plan.plant.reading})", law=plan.form.name, lanes=lanes, version=VERSION,
        generator=GENERATOR, imports=imports,
        operations=parts[0][1] + whole * sum(part[1] for part in parts[1:]),
        fused=parts[0][2] + whole * sum(part[2] for part in parts[1:]),
        bodies="\n\n".join([part[0] for part in parts] + ([fill] if plan.noise == "philox" else [])),
        types=", ".join("count, count" if x == "noise" else "number, count" for x in INPUTS),
        arguments=", ".join(f"{x}_, {x}_n" for x in INPUTS), size=slots.size, buffer=(slots.size + 1) * lanes,
        row=row_width(plan), row_first=slots.first("reference"), sample=slots.first("sample") * lanes, state=2 * n,
        joints=n, recorded=3 * n, applied=slots.first("applied"), tip_square=slots.first("tip_square") * lanes,
        figures=len(slots.all_places(FIGURES)), figures_first=slots.first(FIGURES[0]),
        step="\n".join(" " * 12 + call for call in calls),
    )  # fmt: skip
    return RolloutSource(text, parts[0][1], parts[0][2])


def row_width(plan: StepPlan) -> int:
    """Numbers of one sample of a reference: q, dq, ddq, the tip's place, and noise from a table."""
    widths = plan.slots.widths
    return sum(widths[name] for name in SAMPLE[1:]) - (widths["chance"] if plan.noise == "philox" else 0)


def body_text(plan: StepPlan, step: Step, name: str, lanes: int) -> tuple[str, int, int]:
    """A step as a function of the block, its operations, and those with fused multiply-add."""
    slots = plan.slots
    code = straight_line_code(step.function, sincos("float64"), is_flagged=False)
    given = {
        ("in", i, j): place
        for i, argument in enumerate(step.arguments)
        for j, place in enumerate(slots.places(argument))
    }
    lines = placed_lines(
        code, given, [slots.size, *slots.all_places(step.results)], lanes
    )  # the flag's place is a spare row
    text = _BODY.format(name=name, lanes=lanes, lines="\n".join(lines))
    return text, code.operations, code.operations_after_contraction()


BLOCK = 64
"""Runs that a thread takes at once; a whole number of blocks of lanes."""


@dataclass(frozen=True, slots=True, eq=False)
class Task:
    """What a kernel computes.

    `common` (slots,) and `given` (runs, values) are numbers of a run; `places` (values,) the slots of the latter.
    `reference` (references, samples, width) has rows as `row_width` says, `which` (runs,) picks one for
    each run.
    """

    common: Array
    given: Array
    places: Array
    reference: Array
    which: Array
    seed: int = 0
    first_run: int = 0
    stride: int = 0
    quantiles: tuple[float, ...] = ()

    @property
    def runs(self) -> int:
        """Number of runs."""
        return len(self.given)

    @property
    def samples(self) -> int:
        """Samples of a run."""
        return int(self.reference.shape[1])


@dataclass(frozen=True, slots=True, eq=False)
class Computed:
    """Rows of figures (runs, figures), quantiles over time of the tip's error (runs, quantiles) [m], and the record."""

    figures: Array
    quantiles: Array
    record: Array | None
    """(runs, samples kept, 3 n): q, dq, applied torque."""


@dataclass(frozen=True, slots=True, eq=False)
class RolloutKernel:
    """The machine code of one plan."""

    slots: Slots
    lanes: int
    joints: int
    digest: str
    code: Any

    def run(self, task: Task, threads: int = 1) -> Computed:
        """All runs of a task, blocks of 64 over threads, without the interpreter's lock."""
        runs, kept = task.runs, -(-task.samples // task.stride) if task.stride else 0
        figures = np.empty((runs, len(self.slots.all_places(FIGURES))))
        record = room_for_record(runs, kept, 3 * self.joints) if kept else None
        out = Computed(figures, np.empty((runs, len(task.quantiles))), record)
        shared_out(range(0, runs, BLOCK), partial(self._block, task, out), threads if runs > BLOCK else 1)
        return out

    def _block(self, task: Task, out: Computed, first: int) -> int:
        """The runs from `first` on; gives 0."""
        last = min(first + BLOCK, task.runs)
        _memory, desk = aligned((self.slots.size + 1) * self.lanes * 8)
        trace = np.empty((BLOCK, task.samples)) if task.quantiles else np.empty((1, 1))
        record, kept = (out.figures, 0) if out.record is None else (out.record, out.record.shape[1])
        pairs = {
            "common": (address(task.common), int(bool(task.quantiles))),
            "given": (address(task.given), task.given.shape[1]), "places": (address(task.places), task.samples),
            "reference": (address(task.reference), len(task.reference)),
            "which": (address(task.which), max(task.stride, 1)), "record": (address(record), kept),
            "trace": (address(trace), 0), "noise": (task.seed, task.first_run),
        }  # fmt: skip
        arguments = [x for name in INPUTS for x in pairs[name]]
        self.code.call(*arguments, address(out.figures), desk, first, last)
        if task.quantiles:
            with np.errstate(invalid="ignore"):  # of runs that are not finite
                errors = np.sqrt(trace[: last - first])
                out.quantiles[first:last] = np.quantile(errors, task.quantiles, axis=1).T
        return 0


def room_for_record(runs: int, kept: int, width: int) -> Array:
    """Room for the record; raises `OptionError` where the memory does not hold it."""
    try:
        return np.empty((runs, kept, width))
    except MemoryError:
        size = f"{runs} runs of {kept} samples, {8e-9 * runs * kept * width:.3g} GB"
        raise OptionError("record", size, "what the memory holds: fewer runs, or a larger stride") from None


def plan_key(kind: str, plan: StepPlan, form: str) -> str:
    """Name of a kernel in the cache, from the plan, the generator, the compiler and the processor."""
    return cache_name(kind, [plan.digest, form, *host_cpu(), *map(package_version, ("casadi", *MAKERS))])


_codes: dict[tuple[str, str, str], Any] = {}


def plan_code(kind: str, plan: StepPlan, form: str, source: Callable[[], str], inputs: int) -> Any:
    """The `LoadedCode` of a plan; raises `MissingPackageError` without the extra `batch`."""
    known = kind, plan.digest, form
    if known not in _codes:
        require_packages()
        _codes[known] = kept_code(plan_key(kind, plan, form), source, inputs)
    return _codes[known]


def rollout_kernel(plan: StepPlan, lanes: int | None = None) -> RolloutKernel:
    """The kernel of a plan, in blocks of `lanes` runs: of a vector register if not given; 1 is scalar code.

    Raises `MissingPackageError` without the extra `batch`.
    """
    wide = lanes_of("float64") if lanes is None else lanes
    code = plan_code("rollout", plan, str(wide), lambda: rollout_source(plan, wide).text, len(INPUTS))
    return RolloutKernel(plan.slots, wide, plan.plant.n, plan.digest, code)
