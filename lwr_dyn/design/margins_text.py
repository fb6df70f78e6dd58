"""A margin report in words, for the terminal."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lwr_dyn.design.sampled_stability import pose_text, rate_text
from lwr_dyn.design.sampled_text import unknown_text
from lwr_dyn.foundation.tables import Heading, Table

if TYPE_CHECKING:
    from lwr_dyn.design.margins import MarginReport


def percent(share: float, interval: tuple[float, float]) -> str:
    """A share with its interval at 95 %.

    >>> percent(0.2295, (0.2116, 0.2485))
    '22.9 % (21.2 to 24.9 % at 95 %)'
    """
    return f"{100 * share:.3g} % ({100 * interval[0]:.3g} to {100 * interval[1]:.3g} % at 95 %)"


def margins_text(report: MarginReport) -> str:
    """The report: shares over the poses, then the worst pose joint by joint."""
    found, worst = report.stability, report.worst
    drawn = report.where == "joint box"
    poses = f"{found.poses} poses drawn evenly from the joint box" if drawn else f"{found.poses} given poses"
    lines = [
        f"{report.arm.name}, reading {report.arm.reading}: {report.label}; {report.case.words}",
        "linear and at rest: without speeds, friction, torque limits and stops",
        f"unstable: {_share(report, found.unstable, found.poses, found.interval)} of {poses}",
        rate_text(None) + " makes it hold"
        if found.least_rate is None
        else f"stable from {rate_text(found.least_rate)} on at all of them",
        f"|S_ii| above {report.limit:g}: {_share(report, report.above, report.peak_poses, report.above_interval)}"
        f" of {report.peak_poses} of them",
    ]
    lines += [unknown_text(found)] if found.unknown_limits else []
    lines += [f"note: {note}" for note in report.notes]
    where = pose_text(worst.q, report.arm)
    if not worst.is_stable:
        pole = worst.poles[0]
        kind = "changes its sign at each sample" if pole.real < 0 and abs(pole.imag) < 1e-9 else _swing(report)
        lines += [
            f"worst pose {where}: a deviation grows {worst.radius:.4g}-fold a sample and {kind};"
            f" {report.worst_joint} moves most; no margins there"
        ]
        return "\n".join(lines)
    headings = (
        "joint", Heading("max |S_ii|", format=".3f"), Heading("at", "Hz", ".3g"),
        Heading("gain up to", format=_factor), Heading("gain down to", format=_factor),
    )  # fmt: skip
    rows = list(zip(report.arm.joint_names, worst.peak, worst.peak_hz, worst.gain_up, worst.gain_down, strict=True))
    rows.append(("all together", None, None, worst.all_up, worst.all_down))
    title = f"worst pose {where}, {report.worst_joint}; of the slowest deviation a sample leaves {worst.radius:.4g}"
    delay = f"{1e3 * worst.delay_margin:.3g} ms" if np.isfinite(worst.delay_margin) else "more than was tried"
    return "\n".join([*lines, Table(title, headings, rows).text(), f"all torques may come later by: {delay}"])


def _share(report: MarginReport, count: int, of: int, interval: tuple[float, float]) -> str:
    """A count of given poses, or a share of the box with its interval."""
    return percent(count / of, interval) if report.where == "joint box" else f"{count}"


def _swing(report: MarginReport) -> str:
    hz = abs(np.angle(report.worst.poles[0])) * report.case.rate / (2 * np.pi)
    return f"swings at {hz:.3g} Hz" if hz > 0.0 else "does not swing"


def _factor(value: float) -> str:
    """A gain margin; past what was tried it is said to be so."""
    return "over 1000" if np.isinf(value) else "under 0.001" if value == 0.0 else f"{value:.3g}"
