"""The search over boxes of `control.inertia.certificate` as machine code, the same for all arms (`box_search.c`)."""

from collections.abc import Callable
from functools import cache, partial
from importlib.resources import files

import numpy as np

from lwr_dyn.codegen.kernels.kernel import MAKERS, address, cache_name, kept_code, require_packages
from lwr_dyn.codegen.kernels.loop_code import KernelLoop
from lwr_dyn.codegen.kernels.machine_code import host_cpu
from lwr_dyn.control.inertia.bernstein import WAVES
from lwr_dyn.control.inertia.certificate import LEVELS, BoxSearch, Halvings
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.version import package_version
from lwr_dyn.kinematics.closed_forms import tree
from lwr_dyn.kinematics.closed_forms.text_parser import parsed
from lwr_dyn.kinematics.closed_forms.texts import with_shared

NUMBERS = {"INFINITE": float("inf")}

_INPUTS = 6
"""Pairs of an address and a whole number, as every kernel has them; one number is not used."""


def search_text() -> tree.CText:
    """The text, whose function `search` works on a pool of boxes."""
    text = (files("lwr_dyn.codegen.kernels") / "box_search.c").read_text(encoding="utf-8")
    return parsed(with_shared(text, "search"), {"WAVES": WAVES, "LEVELS": LEVELS})


@cache
def box_search() -> BoxSearch:
    """The row "compiled" of `BOX_SEARCHES`; raises `MissingPackageError`."""
    require_packages()
    loop = KernelLoop(search_text(), "search", (), constants=NUMBERS)
    key = cache_name("boxes", [loop.assembly(), *host_cpu(), *map(package_version, MAKERS)])
    return partial(_searched, kept_code(key, loop.machine_code, _INPUTS).call)


def _searched(
    call: Callable[..., int], halvings: Halvings, pool: Array, gap: float, known: float, most: int
) -> tuple[float, float, int]:
    rows, size = len(pool) - 1, pool.shape[1]
    counts, corners = halvings.counts.astype(float), halvings.corners.astype(float)
    levels, asked, out = np.zeros((rows + 1) * len(counts) + 1), np.array([gap, known]), np.empty(3)
    call(
        address(counts), len(counts), address(halvings.lefts), 0, address(halvings.rights), rows, address(corners),
        len(corners), address(levels), size, address(asked), most, address(out), address(pool), 0, 0,
    )  # fmt: skip
    return float(out[0]), float(out[1]), int(out[2])
