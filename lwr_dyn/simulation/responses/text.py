"""Responses to steps and chirps in words: what `lwr-dyn simulate` prints below a run, and its JSON."""

import math
from typing import Any

from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Run
from lwr_dyn.simulation.responses.frequency import FrequencyResponse, frequency_responses
from lwr_dyn.simulation.responses.step import StepResponse, step_responses

TASKS = ("step", "chirp")


def responses_of(run: Run, arm: Arm | None = None) -> tuple[StepResponse, ...] | tuple[FrequencyResponse, ...]:
    """The responses in a run of the task step or chirp; empty for a run of another one."""
    task = run.meta.get("reference", {}).get("about", {}).get("task")
    return step_responses(run, arm) if task == "step" else frequency_responses(run, arm) if task == "chirp" else ()


def responses_said(run: Run, arm: Arm | None = None) -> tuple[list[str], list[dict[str, Any]]]:
    """The same as lines of text, and as JSON values."""
    return response_lines(run, arm), [response.to_json() for response in responses_of(run, arm)]


def response_lines(run: Run, arm: Arm | None = None) -> list[str]:
    """The same as a table, and a note on torques that were cut."""
    found = responses_of(run, arm)
    if not found:
        return []
    first = found[0]
    table = _steps(found) if isinstance(first, StepResponse) else _chirps(found)
    cut = [f"joint {one.joint} ({one.cut:.3g} s)" for one in found if one.cut > 0.0]
    note = f"torque was cut while {', '.join(cut)} answered: not the response of a linear loop; try a smaller size"
    return [table.text(), *([note] if cut else [])]


def _steps(found: Any) -> Table:
    heads = (
        Heading("joint"), Heading("rise [ms]", format=_number), Heading("overshoot", format=_share),
        Heading("settling [ms]", format=_number), Heading("error left", format=_share),
    )  # fmt: skip
    rows = [(one.joint, 1e3 * one.rise, one.overshoot, 1e3 * one.settling, one.left) for one in found]
    return Table("response to the step: rise 10 to 90 %, settled within 2 %", heads, rows)


def _chirps(found: Any) -> Table:
    heads = (
        Heading("joint"), Heading("bandwidth [Hz]", format=_number), Heading("phase there [deg]", format=_number),
        Heading("largest |H|", format=_number), Heading("at [Hz]", format=_number),
        Heading("least coherence", format=_number),
    )  # fmt: skip
    rows = [
        (one.joint, one.bandwidth, math.degrees(one.phase), one.peak, one.peak_at, one.least_coherence) for one in found
    ]
    return Table("response to the chirp: bandwidth at -3 dB", heads, rows)


def _number(value: float) -> str:
    return "not reached" if math.isnan(value) else f"{value:.4g}"


def _share(value: float) -> str:
    return f"{100.0 * value:.2f} %"
