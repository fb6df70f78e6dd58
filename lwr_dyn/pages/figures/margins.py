"""What a margin report draws: the loops at the worst pose over frequency, the margin over two joints around it."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from lwr_dyn.design.loop_margins import frequency_grid, largest_sensitivity, loop_gain, single_loops
from lwr_dyn.design.margins import COARSE, MarginReport
from lwr_dyn.design.sampled_stability import joint_box, pose_text
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import FileAccessError, OptionError, UnknownNameError
from lwr_dyn.foundation.files import write_file
from lwr_dyn.model.chain import JointKind
from lwr_dyn.pages.figures.figure import Curve, Figure, Level, Panel
from lwr_dyn.pages.plotting import plots
from lwr_dyn.pages.replay.look import tokens

KINDS = ("bode", "nyquist", "sensitivity", "map")
FINE = 1200
"""Frequencies of a drawn curve."""
ACROSS = 41
"""Poses along each side of a map."""
ALONG = 9
"""Poses along each joint by which the joints of a map are chosen."""
BANDS = (1.2, 1.4, 1.7, 2.5, 5.0)
"""Edges of the shades of a map; beyond the last the loop may still be stable."""
NEAR = 3.0
"""Half the side of the part of the plane that a Nyquist picture shows, about -1."""
OTHERS = "other joints"


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
    plots.check_figure(path)

    def write(report: MarginReport, joints: tuple[int, int] | None) -> tuple[Path, Path]:
        if kind == "map":
            return save_map(path, *pose_map(report, joints))
        return plots.save_figure(worst_loops(report).figure(kind), path)

    return write


@dataclass(frozen=True, slots=True, eq=False)
class CutLoops:
    """The loops of an arm at one pose, each cut at one joint with all others closed."""

    hz: Array  # (f,) [Hz]
    loops: Mapping[str, Any]  # name of a joint -> L_i (f,), complex
    shown: str  # the joint that is drawn in ink
    limit: float  # of |S_ii|
    note: str  # what they are loops of, in words

    def figure(self, kind: str) -> Figure:
        """The figure "bode", "nyquist" or "sensitivity"."""
        return {"bode": self._bode, "nyquist": self._nyquist, "sensitivity": self._sensitivity}[kind]()

    def _curves(self, values: Mapping[str, Array], x: Mapping[str, Array] | None = None) -> tuple[Curve, ...]:
        """The curve of the shown joint first, then the others, which share one name."""
        names = [self.shown, *(name for name in self.loops if name != self.shown)]
        return tuple(
            Curve(name if name == self.shown else OTHERS, values[name], self.hz if x is None else x[name])
            for name in names
        )

    def _bode(self) -> Figure:
        size = {name: 20 * np.log10(np.maximum(np.abs(loop), 1e-12)) for name, loop in self.loops.items()}
        phase = {name: np.degrees(np.unwrap(np.angle(loop))) for name, loop in self.loops.items()}
        phase = {name: x - 360 * np.round((x[np.argmin(np.abs(size[name]))] + 180) / 360) for name, x in phase.items()}
        panels = (
            Panel("magnitude, dB", "|L_i|", "dB", self._curves(size), (Level("0 dB", 0.0),)),
            Panel("phase, deg", "phase of L_i", "deg", self._curves(phase), (Level("-180 deg", -180.0),)),
        )
        return Figure("bode", "Bode: the loop cut at one joint", "", "frequency", "Hz", panels, note=self.note)

    def _nyquist(self) -> Figure:
        seen = {name: np.maximum(np.abs(x.real + 1), np.abs(x.imag)) <= NEAR for name, x in self.loops.items()}
        shown = {name: np.where(seen[name], x, complex(np.nan, np.nan)) for name, x in self.loops.items()}
        real, imaginary = ({name: part(x) for name, x in shown.items()} for part in (np.real, np.imag))
        turn, radius = np.linspace(0, 2 * np.pi, 181), 1.0 / self.limit
        circle = Curve(f"|S_ii| = {self.limit:g}", radius * np.sin(turn), radius * np.cos(turn) - 1, colour=0)
        point = Curve("-1", np.array([0.0]), np.array([-1.0]), style="points", colour=0)
        panel = Panel("", "Im L_i", "", (*self._curves(imaginary, real), circle, point))
        title = "Nyquist: the loop cut at one joint"
        return Figure("nyquist", title, "", "Re L_i", "", (panel,), equal_aspect=True, note=self.note)

    def _sensitivity(self) -> Figure:
        size = {name: np.abs(1 / (1 + loop)) for name, loop in self.loops.items()}
        panel = Panel("", "|S_ii|", "", self._curves(size), (Level(f"margin {self.limit:g}", self.limit),))
        return Figure("sensitivity", "Sensitivity of each joint", "", "frequency", "Hz", (panel,), note=self.note)


def worst_loops(report: MarginReport) -> CutLoops:
    """The loops of the worst pose, each cut at one joint, by frequency."""
    sampling = report.case.sampling
    hz = frequency_grid(sampling.rate, FINE)
    loops = single_loops(loop_gain(report.loop, sampling, hz))[0]
    unstable = "" if report.worst.is_stable else ", an unstable loop"
    note = f"all other joints closed; {report.label}; {report.case.words}; {_pose(report)}{unstable}"
    named = dict(zip(report.arm.joint_names, loops.T, strict=True))
    return CutLoops(hz, named, report.worst_joint, report.limit, note)


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
        unit, shown = ("deg", np.degrees) if turning else ("m", np.asarray)
        axes.append((f"{arm.joint_names[joint]}, {unit}", np.asarray(shown(sides[joint]))))
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


def save_map(
    path: str | Path, axes: Sequence[tuple[str, Array]], peaks: Array, here: Sequence[float], words: tuple[str, str]
) -> tuple[Path, Path]:
    """Write a map of max |S_ii| over two joints as .png and .svg; raises as `save_figure`.

    Parameters
    ----------
    path : str or path
    axes : two of (label, (m,) array)
        Across and up, with the unit in the label.
    peaks : (up, across) array
        inf where the loop is unstable.
    here : two floats
        The pose that the other joints are of.
    words : (title, note)
    """
    targets = plots.figure_paths(path)
    for target in targets:
        write_file(target, _map_bytes(axes, peaks, here, words, target.suffix[1:]))
    return targets


def _map_bytes(
    axes: Sequence[tuple[str, Array]], peaks: Array, here: Sequence[float], words: tuple[str, str], kind: str
) -> bytes:
    with plots.drawing_class() as drawing:
        from matplotlib.colors import BoundaryNorm, LinearSegmentedColormap, ListedColormap

        tone = LinearSegmentedColormap.from_list("tone", [tokens()["card"], tokens()["run1"]])
        shades = [tone(x) for x in np.linspace(0.06, 0.85, len(BANDS) + 1)]
        colours = ListedColormap([*shades, tokens()["alarm"]])
        band = np.where(np.isinf(peaks), len(BANDS) + 1, np.digitize(peaks, BANDS))
        picture = drawing(figsize=(6.8, 5.9))
        panel = picture.add_axes((0.1, 0.1, 0.62, 0.715))
        norm = BoundaryNorm(np.arange(-0.5, len(BANDS) + 2), len(BANDS) + 2)
        (across, x), (up, y) = axes
        panel.pcolormesh(x, y, band, cmap=colours, norm=norm, shading="nearest", rasterized=True)
        panel.plot([here[0]], [here[1]], "o", markersize=7, markerfacecolor="none", color=tokens()["ink"])
        for side in panel.spines.values():
            side.set_visible(False)
        panel.tick_params(length=0, labelsize=8.5, pad=4)
        panel.set_xlabel(across, color=tokens()["soft"])
        panel.set_ylabel(up, color=tokens()["soft"])
        picture.text(0.025, 0.955, words[0], fontsize=12.5, fontweight=600, va="center")
        for row, line in enumerate(words[1].split("\n")):
            picture.text(0.025, 0.915 - 0.035 * row, line, color=tokens()["soft"], fontsize=9.0, va="center")
        _legend(picture, [*shades, tokens()["alarm"]])
        return plots.drawing_bytes(picture, kind)


def _legend(picture: Any, shades: Sequence[Any]) -> None:
    """The bands that the map has, from the best down to the unstable one, and the mark of the pose."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Rectangle

    names = [f"up to {BANDS[0]:g}", *(f"{a:g} to {b:g}" for a, b in pairwise(BANDS))]
    names += [f"over {BANDS[-1]:g}", "unstable"]
    picture.text(0.755, 0.785, "max |S_ii|", fontweight=600, va="center")
    for row, (name, shade) in enumerate(zip(names, shades, strict=True)):
        at = 0.74 - 0.045 * row
        edge: dict[str, Any] = {"edgecolor": tokens()["line"], "linewidth": 0.7}
        picture.add_artist(Rectangle((0.755, at - 0.0125), 0.03, 0.025, facecolor=shade, **edge))
        picture.text(0.8, at, name, va="center")
    at = 0.74 - 0.045 * (len(names) + 0.4)
    picture.add_artist(Line2D([0.77], [at], marker="o", markersize=7, markerfacecolor="none", color=tokens()["ink"]))
    picture.text(0.8, at, "worst pose", va="center")
