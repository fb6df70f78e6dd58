"""Under what a run was made: what of its plant the controller's model lacks; whether two runs follow the same."""

from typing import Any

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.run import Run
from lwr_dyn.pages.replay.replayed_runs import PLAIN, facts

SAME = 1e-9
"""[rad or m] References that differ by less are the same: they come from one task, to rounding."""
TIME = 1e-9
"""[s] Times nearer than this are the same."""
ENOUGH = 0.1
"""Share of the samples of the slower run at which references are compared, at least."""


def conditions(run: Run) -> str:
    """What of a run's plant and sensors the controller's model has not, in words, as its file has it."""
    known, meta = facts(run), run.meta
    words = [known[key] for key in ("plant", "payload") if key in known]
    law, options = meta.get("friction_law") or {}, meta.get("options") or {}
    found = {
        "elastic": meta.get("elasticity") is not None,
        "friction": law.get("form", "none") != "none", "encoder": meta.get("encoder") is not None,
        "delay": bool(options.get("delay")),
    }  # fmt: skip
    words += [name for name, is_there in found.items() if is_there and name not in ", ".join(words)]
    return ", ".join(words) or PLAIN


def check_same(a: Run, name_a: str, b: Run, name_b: str) -> None:
    """Raise `OptionError` for runs of different robots or references."""
    subject = f"{name_a} and {name_b}"
    robots = [run.meta.get("file") or run.meta.get("robot") for run in (a, b)]
    if robots[0] != robots[1] or a.n != b.n:
        raise OptionError(subject, f"runs of {robots[0]} and {robots[1]}", "runs of one robot")
    if abs(a.t[-1] - b.t[-1]) > TIME:
        found = f"different references, {a.t[-1]:g} s and {b.t[-1]:g} s long"
        raise OptionError(subject, found, "runs of one reference")
    at_a, at_b = _common_times(a.t, b.t)
    if at_a.size < max(2.0, ENOUGH * min(a.t.size, b.t.size)):
        raise OptionError(subject, "few common times", "runs sampled at rates one of which divides the other")
    apart = np.abs(a.q_ref[at_a] - b.q_ref[at_b]).max(axis=1)
    if apart.max() > SAME:
        k = int(np.argmax(apart))
        found = f"different references, {apart[k]:.3g} rad or m apart at t = {a.t[at_a[k]]:g} s"
        raise OptionError(subject, found, "runs of one reference")


def _common_times(a: Array, b: Array) -> tuple[Any, Any]:
    """Places of the times that both have, in each."""
    ticks_a, ticks_b = (np.round(t / TIME).astype(np.int64) for t in (a, b))
    _, at_a, at_b = np.intersect1d(ticks_a, ticks_b, return_indices=True)
    return at_a, at_b
