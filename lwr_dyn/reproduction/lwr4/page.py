"""What the report page of the LWR-IV exercise shows beside its numbers: the arm with its frames in two positions."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lwr_dyn.checks.verdict import Report
from lwr_dyn.model.arm import Arm
from lwr_dyn.reproduction.lwr4.exercise import Exercise
from lwr_dyn.reproduction.outcome import PageExtras
from lwr_dyn.reproduction.pages import checks_of
from lwr_dyn.reproduction.report.content import Replay, Still


def shown(arm: Arm, found: Exercise, reports: Sequence[Report]) -> PageExtras:
    """Frames in the shown configuration, and where the tool point is asked."""
    place = ", ".join(f"{x + 0.0:.2f}" for x in found.tool)
    stills = (
        Still("Assignment of D-H frames, q = 0", arm, np.zeros(arm.n)),
        Still("tool position", arm, np.radians(found.q_deg), f"the tool point stands at ({place}) m in frame 0"),
    )
    return PageExtras(replay=Replay(stills=stills), checks=checks_of(reports))
