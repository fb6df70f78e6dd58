"""A compiled kernel that keeps every sample of one run: from the cache, or built now."""

import hashlib
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any

import numpy as np

from lwr_dyn.codegen.kernels.cache import read_cache, write_cache
from lwr_dyn.codegen.kernels.kernel import MAKERS, require_packages
from lwr_dyn.codegen.kernels.machine_code import compiled, host_cpu, load
from lwr_dyn.codegen.rollouts.slots import Slots
from lwr_dyn.codegen.rollouts.step import StepPlan
from lwr_dyn.codegen.rollouts.whole_source import AFTER, INPUTS, kept_columns, whole_source
from lwr_dyn.foundation.arrays import Array

REPORTS = 100
_loaded: dict[str, Any] = {}


@dataclass(frozen=True, slots=True, eq=False)
class WholeKernel:
    """The machine code of one plan, for one run at a time."""

    slots: Slots
    code: Any

    def run(self, common: Array, reference: Array, report: Callable[[float], None] | None = None) -> dict[str, Array]:
        """What is kept of each sample, by name: (samples, width) each.

        Parameters
        ----------
        common : (slots,) array
            The numbers of the run, its first state among them.
        reference : (samples, width) array
            As `step_source.row_width` says.
        report : callable, optional
            Called with the share that is done, about a hundred times.
        """
        columns, samples = kept_columns(self.slots), len(reference)
        out = np.empty((samples, columns[AFTER[-1]].stop))
        block = np.empty(self.slots.size + 1)
        size = samples if report is None else max(1, samples // REPORTS)
        arguments = [_address(common), 0, _address(reference), samples, _address(out), _address(block)]
        for first in range(0, samples, size):
            last = min(first + size, samples)
            self.code.call(*arguments, first, last)
            if report is not None:
                report(last / samples)
        return {name: out[:, place] for name, place in columns.items()}


def _address(array: Array) -> int:
    return int(array.__array_interface__["data"][0])


def whole_key_of(plan: StepPlan) -> str:
    """Name of a kernel in the cache, from the plan, the generator, the compiler and the processor."""
    text = [plan.digest, "whole", *host_cpu(), version("casadi"), *map(version, MAKERS)]
    return f"rollout-whole-{hashlib.sha256(chr(10).join(text).encode()).hexdigest()[:40]}"


def whole_kernel(plan: StepPlan) -> WholeKernel:
    """The kernel of a plan with `whole`; raises `MissingPackageError` without the extra `batch`."""
    require_packages()
    key = whole_key_of(plan)
    if key not in _loaded:
        _loaded[key] = _machine_code(plan, key)
    return WholeKernel(plan.slots, _loaded[key])


def _machine_code(plan: StepPlan, key: str) -> Any:
    kept = read_cache(key)
    if kept is not None and isinstance(kept[0].get("symbol"), str):
        return load(kept[1], kept[0]["symbol"], len(INPUTS))
    code, symbol = compiled(whole_source(plan).text)
    write_cache(key, {"symbol": symbol}, code)
    return load(code, symbol, len(INPUTS))
