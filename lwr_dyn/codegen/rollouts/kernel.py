"""A compiled rollout kernel: loaded, from the cache on disk, or built now; and its runs over threads."""

from __future__ import annotations

import hashlib
import threading
from collections import deque
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any

import numpy as np

from lwr_dyn.codegen.kernels.cache import read_cache, write_cache
from lwr_dyn.codegen.kernels.kernel import MAKERS, require_packages
from lwr_dyn.codegen.kernels.machine_code import compiled, host_cpu, lanes_of, load
from lwr_dyn.codegen.rollouts.slots import FIGURES, Slots
from lwr_dyn.codegen.rollouts.step import StepPlan
from lwr_dyn.codegen.rollouts.step_source import INPUTS, rollout_source
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError

BLOCK = 64
"""Runs that a thread takes at once; a whole number of blocks of lanes."""
_ALIGNMENT = 64
_loaded: dict[str, RolloutKernel] = {}
_building = threading.Lock()


@dataclass(frozen=True, slots=True, eq=False)
class Task:
    """What a kernel computes.

    `common` (slots,) and `given` (runs, values) are numbers of a run; `places` (values,) the slots of the latter.
    `reference` (references, samples, width) has rows as `step_source.row_width` says, `which` (runs,) picks one for
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
        left = deque(range(0, runs, BLOCK))

        def work() -> None:
            desk = np.empty((self.slots.size + 1) * self.lanes * 8 + _ALIGNMENT, dtype=np.uint8)
            trace = np.empty((BLOCK, task.samples)) if task.quantiles else np.empty((1, 1))
            while left:
                try:
                    first = left.popleft()
                except IndexError:  # another thread took the last one
                    return
                last = min(first + BLOCK, runs)
                self._block(task, out, desk, trace, first, last)
                if task.quantiles:
                    with np.errstate(invalid="ignore"):  # of runs that are not finite
                        errors = np.sqrt(trace[: last - first])
                        out.quantiles[first:last] = np.quantile(errors, task.quantiles, axis=1).T

        if threads == 1 or len(left) == 1:
            work()
            return out
        with ThreadPoolExecutor(threads - 1, thread_name_prefix="lwr_dyn") as pool:
            others = [pool.submit(work) for _ in range(threads - 1)]
            work()
            for other in others:
                other.result()
        return out

    def _block(self, task: Task, out: Computed, desk: Any, trace: Array, first: int, last: int) -> None:
        place = _address(desk)
        record, kept = (out.figures, 0) if out.record is None else (out.record, out.record.shape[1])
        pairs = {
            "common": (_address(task.common), int(bool(task.quantiles))),
            "given": (_address(task.given), task.given.shape[1]), "places": (_address(task.places), task.samples),
            "reference": (_address(task.reference), len(task.reference)),
            "which": (_address(task.which), max(task.stride, 1)), "record": (_address(record), kept),
            "trace": (_address(trace), 0), "noise": (task.seed, task.first_run),
        }  # fmt: skip
        arguments = [x for name in INPUTS for x in pairs[name]]
        self.code.call(*arguments, _address(out.figures), place + -place % _ALIGNMENT, first, last)


def _address(array: Any) -> int:
    return int(array.__array_interface__["data"][0])


def room_for_record(runs: int, kept: int, width: int) -> Array:
    """Room for the record; raises `OptionError` where the memory does not hold it."""
    try:
        return np.empty((runs, kept, width))
    except MemoryError:
        size = f"{runs} runs of {kept} samples, {8e-9 * runs * kept * width:.3g} GB"
        raise OptionError("record", size, "what the memory holds: fewer runs, or a larger stride") from None


def key_of(plan: StepPlan, lanes: int) -> str:
    """Name of a kernel in the cache, from the plan, the generator, the compiler and the processor."""
    text = [plan.digest, str(lanes), *host_cpu(), version("casadi"), *map(version, MAKERS)]
    return f"rollout-{hashlib.sha256(chr(10).join(text).encode()).hexdigest()[:40]}"


def rollout_kernel(plan: StepPlan, lanes: int | None = None) -> RolloutKernel:
    """The kernel of a plan, in blocks of `lanes` runs: of a vector register if not given; 1 is scalar code.

    Raises `MissingPackageError` without the extra `batch`.
    """
    require_packages()
    wide = lanes_of("float64") if lanes is None else lanes
    key = key_of(plan, wide)
    with _building:
        if key not in _loaded:
            _loaded[key] = _made(plan, wide, key)
    return _loaded[key]


def _made(plan: StepPlan, lanes: int, key: str) -> RolloutKernel:
    slots, kept = plan.slots, read_cache(key)
    symbol = None if kept is None else kept[0].get("symbol")
    if kept is None or not isinstance(symbol, str):
        source = rollout_source(plan, lanes)
        code, symbol = compiled(source.text)
        write_cache(key, {"symbol": symbol, "operations": source.operations, "fused": source.fused}, code)
    else:
        code = kept[1]
    return RolloutKernel(slots, lanes, plan.plant.n, plan.digest, load(code, symbol, inputs=len(INPUTS)))
