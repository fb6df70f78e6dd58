"""Responses as figures: steps over time, chirps as magnitude and phase over frequency, a panel a joint."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.pages.replay.figures import Curve, Figure, Level, Panel
from lwr_dyn.pages.replay.replayed_runs import ReplayedRun
from lwr_dyn.simulation.responses.frequency import HALF_POWER, FrequencyResponse
from lwr_dyn.simulation.responses.step import StepResponse
from lwr_dyn.simulation.responses.text import responses_of

MILLI = 1e3


def response_figures(runs: Sequence[ReplayedRun]) -> tuple[Figure, ...]:
    """Steps [share of the step] or frequency responses [dB, deg] of runs side by side.

    Raises `OptionError` for runs of other tasks, or of both.
    """
    found: Any = [responses_of(one.run, one.arm) for one in runs]
    kinds = {type(response) for each in found for response in each}
    if len(kinds) != 1 or not all(found):
        raise OptionError("runs", "not all of the task step, or not all of the task chirp", "runs of one of them")
    return (_steps(runs, found) if kinds == {StepResponse} else _chirps(runs, found),)


def _steps(runs: Sequence[ReplayedRun], found: Sequence[Sequence[StepResponse]]) -> Figure:
    panels = []
    for joint in (response.joint for response in found[0]):
        mine = [(one, r) for one, each in zip(runs, found, strict=True) for r in each if r.joint == joint]
        curves = tuple(Curve(one.caption, r.y, MILLI * r.t, colour=one.place) for one, r in mine)
        first = mine[0][1]
        note = f"rise {MILLI * first.rise:.3g} ms, overshoot {100.0 * first.overshoot:.2g} %" if len(mine) == 1 else ""
        panels.append(Panel(f"joint {joint}", "share of the step", "", curves, (Level("asked for", 1.0),), note))
    return Figure("response", "Responses to a step", "", "time from the step", "ms", tuple(panels), columns=2)


def _chirps(runs: Sequence[ReplayedRun], found: Sequence[Sequence[FrequencyResponse]]) -> Figure:
    panels = []
    for joint in (response.joint for response in found[0]):
        mine = [(one, r) for one, each in zip(runs, found, strict=True) for r in each if r.joint == joint]
        size = tuple(Curve(one.caption, 20.0 * np.log10(np.abs(r.H)), r.f, colour=one.place) for one, r in mine)
        angle = tuple(
            Curve(one.caption, np.degrees(np.unwrap(np.angle(r.H))), r.f, colour=one.place) for one, r in mine
        )
        first = mine[0][1]
        reached = "beyond the sweep" if np.isnan(first.bandwidth) else f"{first.bandwidth:.3g} Hz"
        note = f"bandwidth {reached}" if len(mine) == 1 else ""
        level = Level("bandwidth", float(20.0 * np.log10(HALF_POWER)))
        panels.append(Panel(f"joint {joint}, magnitude in dB", "magnitude", "dB", size, (level,), note))
        panels.append(Panel(f"joint {joint}, phase in deg", "phase", "deg", angle))
    return Figure("response", "Frequency responses", "", "frequency", "Hz", tuple(panels), columns=2)
