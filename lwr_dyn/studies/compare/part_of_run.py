"""Parts of a run: from a time on, as the second pass of a task done twice; fewer samples of it, for pages."""

from dataclasses import replace
from typing import Any

import numpy as np

from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.run import Run
from lwr_dyn.pages.replay.page_parts import subsample
from lwr_dyn.trajectory.references.twice import part_of

_SAMPLED = ("t", "q", "dq", "q_ref", "dq_ref", "tau_command", "tau_applied", "tau_friction", "energy")


def since(run: Run, start: float) -> Run:
    """The run from `start` [s] on, with its time counted from there; its audit is that of the whole run.

    Raises
    ------
    OptionError
        A start that is negative or not below the end.
    """
    if start == 0.0:
        return run
    if not 0.0 < start < run.t[-1]:
        raise OptionError("since", f"{start:g} s", f"a time from 0 to below {run.t[-1]:g} s, the end of the run")
    part = part_of(run, start)
    note = {**(run.meta.get("note") or {}), "since": start}
    return replace(part, meta={**part.meta, "audit": dict(run.audit), "note": note})


def thinned(run: Run, rate: float) -> Run:
    """The run at about `rate` samples a second [Hz], its last sample included; a run with fewer is kept as it is.

    >>> import lwr_dyn
    >>> arm = lwr_dyn.load("lwr4plus")
    >>> hold = lwr_dyn.reference("hold", arm, q=[0.1] * 7, duration=0.1)
    >>> thinned(lwr_dyn.simulate(arm, lwr_dyn.controller("inverse-dynamics", arm), hold), 100.0).t.size
    11
    """
    stride = round((run.t.size - 1) / max(float(np.ptp(run.t)) * rate, 1e-9))
    if stride < 2:
        return run
    rows = subsample(run.t.size, stride)
    arrays = {name: getattr(run, name)[rows] for name in _SAMPLED}
    kept: dict[str, Any] = {
        what: {name: x[rows] for name, x in getattr(run, what).items()} for what in ("work", "signals")
    }
    return replace(run, **arrays, **kept)
