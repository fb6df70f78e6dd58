"""A rollout kernel: its loop over blocks of W runs (`kernel.c`), its machine code, and its runs over threads.

A block holds W lanes of every slot. Numbers of a run that are not given for each are copied from a common row, so the
same kernel serves whatever varies; the rows of a reference are shared, or picked lane by lane.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from importlib.resources import files
from typing import Any

import numpy as np

from lwr_dyn.codegen.kernels.elementary import sincos
from lwr_dyn.codegen.kernels.kernel import MAKERS, address, aligned, cache_name, kept_code, require_packages, shared_out
from lwr_dyn.codegen.kernels.kernel_source import placed_lines
from lwr_dyn.codegen.kernels.loop_code import KernelLoop, LaneBody
from lwr_dyn.codegen.kernels.machine_code import host_cpu, lanes_of
from lwr_dyn.codegen.kernels.straight_line import straight_line_code
from lwr_dyn.codegen.rollouts.philox_code import uniform_code
from lwr_dyn.codegen.rollouts.step import FIGURES, SAMPLE, Slots, Step, StepPlan, steps
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.version import package_version
from lwr_dyn.kinematics.closed_forms.text_parser import parsed

INPUTS = ("common", "given", "places", "reference", "which", "record", "trace", "noise")
"""Pairs of an address and a number, in this order: the common row and whether runs are traced; values of each run and
how many; their slots and the number of samples; references and how many; the reference of each run and the record's
stride; the record and its samples; the squares of the tip's error; seed and number of the first run."""

_BODY = """def {name}(b):
    for k in range({lanes}):
{lines}
"""

_STEP = """
/* a sample */
static void step(double *b, int seed, int run, int sample)
{{
    {noise}body(b);{motion}
}}
"""

_MOTION = """
    for (int i = 0; i < SUBSTEPS; i++) {
        motion(b);
    }"""


@dataclass(frozen=True, slots=True)
class PlanLoop:
    """The loop of a plan, with its operations a sample, and those of them with fused multiply-add."""

    loop: KernelLoop
    operations: int
    fused: int


def rollout_loop(plan: StepPlan, lanes: int) -> PlanLoop:
    """The loop of a plan's rollouts in blocks of `lanes` runs."""
    places = {
        "SAMPLE": plan.slots.first("sample"), "APPLIED": plan.slots.first("applied"), "N": plan.plant.n,
        "TIP_SQUARE": plan.slots.first("tip_square"), "FIGURES": len(plan.slots.all_places(FIGURES)),
        "FIRST_FIGURE": plan.slots.first(FIGURES[0]),
    }  # fmt: skip
    text = (files("lwr_dyn.codegen.rollouts") / "kernel.c").read_text(encoding="utf-8")
    return loop_of(plan, text, "rollouts", lanes, places)


def loop_of(plan: StepPlan, text: str, entry: str, lanes: int, places: Mapping[str, int]) -> PlanLoop:
    """The loop of a text that calls `step` for each sample, with numbers of its own besides those of every plan."""
    slots, found = plan.slots, [body_of(plan, *x, lanes) for x in zip(steps(plan), ("body", "motion"), strict=False)]
    has_noise = plan.noise == "philox"
    step = _STEP.format(
        noise="fill(b, seed, run, sample);\n    " if has_noise else "", motion=_MOTION if len(found) > 1 else ""
    )
    every = {
        "W": lanes, "SIZE": slots.size, "ROW": row_width(plan), "REFERENCE": slots.first("reference"),
        "SUBSTEPS": plan.substeps,
    }  # fmt: skip
    fill = (uniform_code("fill", lanes, slots.widths["chance"], slots.first("chance")),) if has_noise else ()
    loop = KernelLoop(parsed(step + text, every | dict(places)), entry, tuple(x.body for x in found), fill)
    first, *others = (x.counts for x in found)
    operations, fused = (first[i] + plan.substeps * sum(x[i] for x in others) for i in (0, 1))
    return PlanLoop(loop, operations, fused)


def row_width(plan: StepPlan) -> int:
    """Numbers of one sample of a reference: q, dq, ddq, the tip's place, and noise from a table."""
    widths = plan.slots.widths
    return sum(widths[name] for name in SAMPLE[1:]) - (widths["chance"] if plan.noise == "philox" else 0)


@dataclass(frozen=True, slots=True)
class _CountedBody:
    """A body, its operations, and those with fused multiply-add."""

    body: LaneBody
    counts: tuple[int, int]


def body_of(plan: StepPlan, step: Step, name: str, lanes: int) -> _CountedBody:
    """A step as a function of the block."""
    slots = plan.slots
    code = straight_line_code(step.function, sincos("float64"), is_flagged=False)
    given = {
        ("in", i, j): place
        for i, argument in enumerate(step.arguments)
        for j, place in enumerate(slots.places(argument))
    }
    places = [slots.size, *slots.all_places(step.results)]  # the flag's place is a spare row
    lines = placed_lines(code, given, places, lanes)
    text = _BODY.format(name=name, lanes=lanes, lines="\n".join(lines))
    return _CountedBody(LaneBody(name, text), (code.operations, code.operations_after_contraction()))


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


def plan_code(kind: str, plan: StepPlan, form: str, made: Callable[[], PlanLoop], inputs: int) -> Any:
    """The `LoadedCode` of a plan; raises `MissingPackageError` without the extra `batch`."""
    known = kind, plan.digest, form
    if known not in _codes:
        require_packages()
        _codes[known] = kept_code(plan_key(kind, plan, form), lambda: made().loop.machine_code(), inputs)
    return _codes[known]


def rollout_kernel(plan: StepPlan, lanes: int | None = None) -> RolloutKernel:
    """The kernel of a plan, in blocks of `lanes` runs: of a vector register if not given; 1 is scalar code.

    Raises `MissingPackageError` without the extra `batch`.
    """
    wide = lanes_of("float64") if lanes is None else lanes
    code = plan_code("rollout", plan, str(wide), lambda: rollout_loop(plan, wide), len(INPUTS))
    return RolloutKernel(plan.slots, wide, plan.plant.n, plan.digest, code)
