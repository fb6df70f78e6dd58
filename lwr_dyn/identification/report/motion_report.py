"""A fit to any motion as a page: its document with the motion in 3D, torques, friction and the recordings.

From a fit to what the figures draw: full parameters, predicted torques, friction over speed.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from html import escape
from math import hypot, sqrt
from pathlib import Path

import numpy as np

from lwr_dyn.dynamics.regressor import INERTIAL
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.document import Document, Fact, Note, PageFigure, Section
from lwr_dyn.foundation.errors import FileAccessError
from lwr_dyn.foundation.files import check_writable, ends_in
from lwr_dyn.foundation.number_text import short
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.identification.motion.motion_result import MotionIdentification, motion_document
from lwr_dyn.identification.motion.validation import Validation
from lwr_dyn.identification.regression.information import Information
from lwr_dyn.identification.regression.samples import Samples
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.identification.report import charts
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import JointKind
from lwr_dyn.model.friction import JointFriction
from lwr_dyn.pages.replay.replay_page import resource_text

MOST_ROWS = 12_000
"""Instants of a recording that the page draws: two minutes at 100 Hz; of longer ones every second, third, ..."""
MOST_RECORDINGS = 8
"""Recordings that are drawn, the first ones."""
_BLOCK = 1000


@dataclass(frozen=True, slots=True, eq=False)
class DrawnFit:
    """The recordings as they are drawn, and the dots of the friction maps: speed and torque (k, n)."""

    recordings: tuple[charts.ShownRecording, ...]
    speed: Array
    torque: Array
    left_out: int
    """Recordings that are not drawn."""
    every: int
    """Of the longest recording drawn, one in so many instants is there."""


def full_parameters(information: Information, arm: Arm) -> Array:
    """All parameters (p,): those that fit best and are nearest to the arm's own, column by column to its scale.

    Of the sets with the fitted base values, the one with the least sum of squared relative changes; no set of bodies
    need have them.
    """
    own, grouping = information.columns.own(arm), information.base.grouping
    weight = np.square(np.maximum(np.abs(own), 1e-3 * np.abs(own).max()))
    missing = information.values - grouping @ own
    pull = (grouping * weight) @ grouping.T
    return np.asarray(own + weight * (grouping.T @ np.linalg.solve(pull, missing)))


def drawn_fit(samples: Samples, columns: TorqueColumns, parameters: Array) -> DrawnFit:
    """Torques as parameters (p,) predict them, and what bodies and rotors leave of the measured ones.

    With a transmission, speeds and friction are those of the motors.
    """
    numbers = np.unique(samples.recording)
    rigid = parameters.copy()
    rigid[columns.friction_indices] = 0.0
    recordings, speeds, torques, every = [], [], [], 1
    names = _names([samples.sources[k] for k in numbers])
    for name, k in zip(names[:MOST_RECORDINGS], numbers[:MOST_RECORDINGS], strict=True):
        rows = np.flatnonzero(samples.recording == k)
        step = -(-rows.size // MOST_ROWS)
        one, every = samples.select(rows[::step]), max(every, step)
        whole, bodies = _torques(one, columns, parameters, rigid)
        cut = ~one.used & (one.tau == 0.0)  # a torque that was cut out stands as 0 there
        measured = np.where(cut, np.nan, one.tau)
        recordings.append(charts.ShownRecording(name, one.t - one.t[0], one.q, measured, whole, one.used))
        left = np.where(one.used, one.tau - bodies, np.nan)
        speeds.append(one.dq if columns.transmission is None else one.dq @ columns.transmission.matrix.T)
        if columns.transmission is not None:  # torques of the motors: T^T tau_m = tau; NaN where one joint's is unknown
            left = np.asarray(np.linalg.solve(columns.transmission.matrix.T, left.T).T)
        torques.append(left)
    hidden = len(numbers) - len(recordings)
    return DrawnFit(tuple(recordings), np.concatenate(speeds), np.concatenate(torques), hidden, every)


def _torques(one: Samples, columns: TorqueColumns, *sets: Array) -> Iterator[Array]:
    """Y pi (k, n) of each parameter set, in blocks."""
    both = np.column_stack(sets)
    blocks = [slice(k, k + _BLOCK) for k in range(0, len(one), _BLOCK)]
    out = np.concatenate([columns(one.q[b], one.dq[b], one.ddq[b]) @ both for b in blocks])
    return (out[..., k] for k in range(len(sets)))


def _names(sources: Sequence[str]) -> list[str]:
    """A name a recording: the file, numbered where it has several."""
    return [
        source if sources.count(source) == 1 else f"{source} ({list(sources[: k + 1]).count(source)})"
        for k, source in enumerate(sources)
    ]


def link_parameters(columns: TorqueColumns, parameters: Array) -> Array:
    """The ten of each link, (n, 10)."""
    return np.asarray(parameters[: columns.bodies].reshape(columns.n, len(INERTIAL)))


UNITS = {JointKind.REVOLUTE: ("rad/s", "N m"), JointKind.PRISMATIC: ("m/s", "N")}
"""Of speed and torque."""


@dataclass(frozen=True, slots=True, eq=False)
class DrawnMotion:
    """What the figures show of a fit.

    `noise` (n,) is the standard deviation of the torques [N m or N]; `before` and `after` (n, 10) are the inertial
    parameters of the links, the table's and the result's, in the frames of the source; `speed` and `friction_torque`
    (k, n) are the dots of the friction maps, NaN where a torque is not used; `friction_at` says whose friction it is.
    """

    arm: Arm
    recordings: tuple[charts.ShownRecording, ...]
    noise: Array
    before: Array
    after: Array
    speed: Array
    friction_torque: Array
    friction: tuple[JointFriction | None, ...]
    friction_before: tuple[JointFriction | None, ...]
    friction_at: tuple[str, ...]


def motion_page(
    result: MotionIdentification, *, unseen: Sequence[Validation] = (), more: Sequence[Section] = (),
    command: str = "lwr-dyn identify motion",
) -> Document:  # fmt: skip
    """The document of a fit with its figures; `more` are sections at the end, such as what slips of the table show."""
    drawn, motion = _drawn(result)
    document = motion_document(result, unseen=unseen)
    lead, *rest = document.sections
    sections = [lead, *figure_sections(motion), *rest, *more, _recordings(result, drawn)]
    facts = [*document.facts, *_shares(result)]
    return replace(document, sections=sections, command=command, facts=facts)


def _shares(result: MotionIdentification) -> list[Fact]:
    """Tiles of the page: of the torques that no fit saw, how much the result leaves and the robot's own data."""

    def over_joints(values: Sequence[float]) -> float:
        known = [x for x in values if np.isfinite(x)]
        return hypot(*known) / sqrt(len(known)) if known else float("nan")

    rows = result.validation
    measured, model = (over_joints([getattr(v, key) for v in rows]) for key in ("measured", "model"))
    left = over_joints([v.held_out if v.consistent is None else v.consistent for v in rows])
    worst = int(np.nanargmax(result.information.residual_noise))
    unit = "N m" if result.arm.chain.links[worst].kind.value == "revolute" else "N"
    shown = [
        ("of unseen torques left, by the result", 100 * left / measured if measured else None, "%", ".3g"),
        ("left by the robot's own data", 100 * model / measured if measured else None, "%", ".3g"),
        (f"noise, largest at {result.arm.joint_names[worst]}", result.information.residual_noise[worst], unit, ".2g"),
    ]
    return [Fact(None, value, "", head, unit, form, page=True) for head, value, unit, form in shown]


def check_report_path(path: str | Path) -> None:
    """Raise `FileAccessError` now for a path that a report could not be written to later."""
    if not ends_in(path, ".html", ".htm"):
        raise FileAccessError(str(path), f"ends in {Path(path).suffix or 'nothing'!r}", "a path in .html")
    check_writable(path)


def _drawn(result: MotionIdentification) -> tuple[DrawnFit, DrawnMotion]:
    arm, columns, fit = result.arm, result.columns, result.consistent
    parameters = full_parameters(result.information, arm) if fit is None else fit.parameters
    drawn, motors = drawn_fit(result.samples, columns, parameters), columns.transmission is not None
    return drawn, DrawnMotion(
        arm, drawn.recordings, result.information.residual_noise, link_parameters(columns, columns.own(arm)),
        link_parameters(columns, parameters), drawn.speed, drawn.torque, columns.friction_of(parameters),
        (None,) * arm.n if motors else arm.friction_models(),
        tuple(f"motor {j + 1}" for j in range(arm.n)) if motors else arm.joint_names,
    )  # fmt: skip


def figure_sections(drawn: DrawnMotion) -> list[Section]:
    """The motion in 3D with the links before and after, torques against their prediction, friction over speed."""
    units = [UNITS[link.kind] for link in drawn.arm.chain.links]
    stage = PageFigure(
        lambda: charts.stage_html(drawn.recordings), resource_text("report.css", charts.PACKAGE),
        lambda: charts.stage_scripts(charts.stage_data(drawn.arm, drawn.recordings, drawn.before, drawn.after)),
    )  # fmt: skip
    return [
        Section("The motion, and the links before and after", [Note(ELLIPSOIDS), stage, link_table(drawn)], page=True),
        Section(
            "Torque against prediction", [PageFigure(lambda: _torques_html(drawn, [u[1] for u in units]))], page=True
        ),
        Section("Friction", [Note(DOTS), PageFigure(lambda: charts.friction_maps_html(
            drawn.speed, drawn.friction_torque, drawn.friction, drawn.friction_before, drawn.friction_at, tuple(units)
        ))], page=True),
    ]  # fmt: skip


ELLIPSOIDS = (
    "Each ellipsoid is the solid of one density with the mass, the centre of mass and the inertia of a link: wires "
    "by the table, filled by the result. A link without an ellipsoid has values that no body can have."
)
DOTS = (
    "Dots: measured torque less what the bodies and rotors of the result take. Line: the friction of the result; "
    "grey: that of the robot's data, if it has any."
)


def _torques_html(drawn: DrawnMotion, units: Sequence[str]) -> str:
    names = [escape(one.source) for one in drawn.recordings]
    options = "".join(f'<option value="{k}">{name}</option>' for k, name in enumerate(names))
    choice = f'<p class="pick"><label>recording <select class="which">{options}</select></label></p>'
    drawn_rows = "".join(
        f'<div data-recording="{k}"{" hidden" if k else ""}>'
        f"{charts.torque_rows_html(one, drawn.noise, drawn.arm.joint_names, tuple(units))}</div>"
        for k, one in enumerate(drawn.recordings)
    )
    return (choice if len(names) > 1 else "") + charts.KEY + drawn_rows


def link_table(drawn: DrawnMotion) -> Table:
    """Mass, centre of mass and ellipsoid of each link, by the table and by the result."""
    rows = []
    for link, before, after in zip(drawn.arm.chain.links, drawn.before, drawn.after, strict=True):
        (m0, c0, _), (m1, c1, _) = charts.central_moments(before), charts.central_moments(after)
        moved = 1e3 * float(np.linalg.norm(c1 - c0)) if m0 > 0.0 and m1 > 0.0 else None
        rows.append((link.link, m0, m1, moved, _axes(before), _axes(after), charts.link_ellipsoid(after) is not None))
    columns = (
        Heading("link"), Heading("mass, table", "kg", short), Heading("mass", "kg", short),
        Heading("centre moved by", "mm", short), Heading("semi-axes, table", "mm"),
        Heading("semi-axes", "mm"), Heading("a body", "", lambda x: "yes" if x else "no"),
    )  # fmt: skip
    return Table("Links, by the table and by the result", columns, rows, page=True)


def _axes(parameters: Array) -> str:
    found = charts.link_ellipsoid(parameters)
    return "none" if found is None else ", ".join(f"{1e3 * x:.0f}" for x in found.semi_axes)


def _recordings(result: MotionIdentification, drawn: DrawnFit) -> Section:
    samples, names = result.samples, np.array(result.arm.joint_names)
    rows = []
    for which in np.unique(samples.recording):
        chosen = samples.recording == which
        t, still = samples.t[chosen], np.ptp(samples.q[chosen], axis=0) < 1e-3
        rows.append((samples.sources[which], float(t[-1] - t[0]), int(chosen.sum()),
                     int(samples.used[chosen].sum()), ", ".join(names[still]) or "none"))  # fmt: skip
    columns = (
        Heading("recording"), Heading("length", "s", ".4g"), Heading("instants"), Heading("equations"),
        Heading("joints that stand still"),
    )  # fmt: skip
    return Section("Recordings", [
        Table("Recordings", columns, rows),
        Note("Equations of joints that are slow, and torques that were cut out, are not used."),
        Note(f"{drawn.left_out} more recordings are fitted and not drawn.", drawn.left_out > 0),
        Note(f"Of the longest recording one in {drawn.every} instants is drawn.", drawn.every > 1),
    ], page=True)  # fmt: skip
