"""What a margin report draws: the loops at the worst pose over frequency, the margin over two joints around it."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from lwr_dyn.design.loop_margins import frequency_grid, largest_sensitivity, loop_gain, single_loops
from lwr_dyn.design.margins import COARSE, MarginReport
from lwr_dyn.design.sampled_stability import joint_box, pose_text
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import FileAccessError, OptionError, UnknownNameError, needs_extra
from lwr_dyn.model.chain import JointKind

KINDS = ("bode", "nyquist", "sensitivity", "map")
FINE = 1200
"""Frequencies of a drawn curve."""
ACROSS = 41
"""Poses along each side of a map."""
ALONG = 9
"""Poses along each joint by which the joints of a map are chosen."""


def picture_writer(wish: str) -> Callable[[MarginReport, tuple[int, int] | None], tuple[Path, Path]]:
    """What `--plot` means, checked before the work: a function that draws a report and returns its .png and .svg.

    A path that ends in .png or .svg is named after what it shows; another text is bode, nyquist, sensitivity or map.

    Raises
    ------
    UnknownNameError
        Another picture.
    FileAccessError, MissingPackageError
        Nothing can be written there; Matplotlib is missing.
    """
    path = Path(wish)
    kind = next((kind for kind in KINDS if kind in path.stem.lower()), None)
    if path.suffix.lower() not in ("", ".png", ".svg"):
        raise FileAccessError(wish, f"ends in {path.suffix}", "a path that ends in .png or .svg, or a name")
    if kind is None:
        raise UnknownNameError("picture", wish, KINDS)
    with needs_extra("plots"):
        from lwr_dyn.pages.plotting.plots import LoopPictures
    LoopPictures.check(path)

    def write(report: MarginReport, joints: tuple[int, int] | None) -> tuple[Path, Path]:
        written: tuple[Path, Path]
        if kind == "map":
            written = LoopPictures.save_map(path, *pose_map(report, joints))
        else:
            written = LoopPictures(**loop_curves(report)).save(kind, path)
        return written

    return write


def loop_curves(report: MarginReport) -> dict[str, Any]:
    """The loops of the worst pose, each cut at one joint, by frequency; fields of `LoopPictures`."""
    sampling = report.case.sampling
    hz = frequency_grid(sampling.rate, FINE)
    loops = single_loops(loop_gain(report.loop, sampling, hz))[0]
    unstable = "" if report.worst.is_stable else ", an unstable loop"
    note = f"all other joints closed; {report.label}; {report.case.words}; {_pose(report)}{unstable}"
    named = dict(zip(report.arm.joint_names, loops.T, strict=True))
    return {"hz": hz, "loops": named, "shown": report.worst_joint, "limit": report.limit, "note": note}


def pose_map(
    report: MarginReport, joints: tuple[int, int] | None = None
) -> tuple[list[tuple[str, Array]], Array, list[float], tuple[str, str]]:
    """max |S_ii| over two joints (0-based) inside their limits, all others as in the worst pose: what `save_map` takes.

    The two joints that change it most, one at a time, are taken if none are given. Raises `OptionError` for others.
    """
    arm, worst = report.arm, report.worst.q
    if arm.n < 2:
        raise OptionError("map", f"{arm.name} has one joint", "an arm with two joints or more")
    across, up = _most_felt(report) if joints is None else joints
    if not (min(across, up) >= 0 and max(across, up) < arm.n and across != up):
        raise OptionError("joints of the map", f"{across + 1}, {up + 1}", f"two of the joints 1 to {arm.n}")
    sides = [np.linspace(low, high, ACROSS) for low, high in zip(*joint_box(arm)[:2], strict=True)]
    rows = np.tile(worst, (ACROSS, ACROSS, 1))
    rows[..., across], rows[..., up] = sides[across], sides[up][:, None]
    peaks = _peaks(report, rows.reshape(-1, arm.n)).reshape(ACROSS, ACROSS)
    axes, here = [], []
    for joint in (across, up):
        turning = arm.chain.links[joint].kind is JointKind.REVOLUTE
        shown = np.degrees if turning else np.asarray
        axes.append((f"{arm.joint_names[joint]}, {'deg' if turning else 'm'}", np.asarray(shown(sides[joint]))))
        here.append(float(shown(worst[joint])))
    title = f"Margin of {arm.name}, reading {arm.reading}"
    note = f"{report.label}; {report.case.words}\nother joints as at the {_pose(report)}"
    return axes, peaks, here, (title, note)


def _peaks(report: MarginReport, rows: Array) -> Array:
    return np.asarray(largest_sensitivity(report.loops(rows), report.case.sampling, COARSE).max(axis=1))


def _most_felt(report: MarginReport) -> tuple[int, int]:
    """The two joints that, moved alone from the worst pose through their range, change growth and max |S_ii| most."""
    lower, upper, _ = joint_box(report.arm)
    rows = np.tile(report.worst.q, (report.arm.n, ALONG, 1))
    for j in range(report.arm.n):
        rows[j, :, j] = np.linspace(lower[j], upper[j], ALONG)
    rows = rows.reshape(-1, report.arm.n)
    felt = np.log(np.minimum(_peaks(report, rows), 1e3)) + np.log(report.loops(rows).radius(report.case.sampling))
    first, second = np.argsort(-np.ptp(felt.reshape(report.arm.n, ALONG), axis=1), kind="stable")[:2]
    return min(int(first), int(second)), max(int(first), int(second))


def _pose(report: MarginReport) -> str:
    return f"worst pose {pose_text(report.worst.q, report.arm)}"
