"""A fit to any motion (`identify_motion`) as the report shows it: head figures, bodies, checks, recordings.

From a fit to what the page shows: full parameters, predicted torques, friction over speed, a row a parameter.

Cards on what a fit to any motion is worth: validation, whiteness, price of bodies, what is known only together.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import hypot, sqrt

import numpy as np

from lwr_dyn.dynamics.regressor import INERTIAL
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.identification.motion.identifiable import FROM_BOTH, FROM_LOG, FROM_TABLE, MEANING, TOGETHER
from lwr_dyn.identification.motion.motion_fit import MotionIdentification
from lwr_dyn.identification.motion.motion_tables import NOISE_MODEL, body_lines, validation_table
from lwr_dyn.identification.motion.validation import LAGS, LEVEL, Validation
from lwr_dyn.identification.regression.information import Information
from lwr_dyn.identification.regression.samples import Samples
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.identification.report.charts import ShownRecording
from lwr_dyn.identification.report.shown_fit import Section, ShownFit, ShownParameter, number
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.transmission import Transmission

MOST_ROWS = 12_000
"""Instants of a recording that the page draws: two minutes at 100 Hz; of longer ones every second, third, ..."""

MOST_RECORDINGS = 8
"""Recordings that are drawn, the first ones."""

_BLOCK = 1000


@dataclass(frozen=True, slots=True, eq=False)
class DrawnFit:
    """The recordings as they are drawn, and the dots of the friction maps: speed and torque (k, n)."""

    recordings: tuple[ShownRecording, ...]
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
    rigid[columns.bodies :] = 0.0
    rigid[columns.rotor_indices] = parameters[columns.rotor_indices]
    recordings, speeds, torques, every = [], [], [], 1
    names = _names([samples.sources[k] for k in numbers])
    for name, k in zip(names[:MOST_RECORDINGS], numbers[:MOST_RECORDINGS], strict=True):
        rows = np.flatnonzero(samples.recording == k)
        step = -(-rows.size // MOST_ROWS)
        one, every = samples.select(rows[::step]), max(every, step)
        whole, bodies = _torques(one, columns, parameters, rigid)
        cut = ~one.used & (one.tau == 0.0)  # a torque that was cut out stands as 0 there
        measured = np.where(cut, np.nan, one.tau)
        recordings.append(ShownRecording(name, one.t - one.t[0], one.q, measured, whole, one.used))
        left = np.where(one.used, one.tau - bodies, np.nan)
        speeds.append(one.dq if columns.transmission is None else one.dq @ columns.transmission.matrix.T)
        torques.append(left if columns.transmission is None else _at_motors(left, columns.transmission))
    hidden = len(numbers) - len(recordings)
    return DrawnFit(tuple(recordings), np.concatenate(speeds), np.concatenate(torques), hidden, every)


def _torques(one: Samples, columns: TorqueColumns, *sets: Array) -> Iterator[Array]:
    """Y pi (k, n) of each parameter set, in blocks."""
    both = np.column_stack(sets)
    blocks = [slice(k, k + _BLOCK) for k in range(0, len(one), _BLOCK)]
    out = np.concatenate([columns(one.q[b], one.dq[b], one.ddq[b]) @ both for b in blocks])
    return (out[..., k] for k in range(len(sets)))


def _at_motors(left: Array, transmission: Transmission) -> Array:
    """Torques of the motors (k, n): T^T tau_m = tau; NaN where one joint's is unknown."""
    return np.asarray(np.linalg.solve(transmission.matrix.T, left.T).T)


def _names(sources: Sequence[str]) -> list[str]:
    """A name a recording: the file, numbered where it has several."""
    return [
        source if sources.count(source) == 1 else f"{source} ({list(sources[: k + 1]).count(source)})"
        for k, source in enumerate(sources)
    ]


def link_parameters(columns: TorqueColumns, parameters: Array) -> Array:
    """The ten of each link, (n, 10)."""
    return np.asarray(parameters[: columns.bodies].reshape(columns.n, len(INERTIAL)))


def parameter_rows(
    information: Information, arm: Arm, states: Sequence[str], bodies: Array | None = None
) -> tuple[ShownParameter, ...]:
    """A row a base parameter, with the arm's own value and that of the result's bodies (b,)."""
    own = information.base.of(information.columns.own(arm))
    bodies = np.full(own.size, np.nan) if bodies is None else bodies
    rows = zip(information.base.statements(), information.values, information.sigma, own, bodies, states, strict=True)
    return tuple(
        ShownParameter(name, float(value), float(sigma), float(table), float(body), state)
        for name, value, sigma, table, body, state in rows
    )


_MOST = 12
"""Groups and motions that are named."""


def validation_section(result: MotionIdentification, unseen: Sequence[Validation] = ()) -> Section:
    """RMS torques by joint on motions kept from the fit, on logs of their own, and whether residuals are white."""
    parts = f"{result.rule.folds} parts of the motion, each kept from a fit in turn"
    tables = [validation_table(result.validation, parts)]
    tables += [validation_table(unseen, "logs that no fit has seen")] if unseen else []
    notes = (
        "Bodies: by fits whose links are bodies. Model: by the robot's table with its own friction.",
        f"White: noise alone gives as large a statistic of {LAGS} lags in more than {100 * LEVEL:g} % of logs (Box and "
        "Pierce, 1970); correlation: of an instant with the next. Where they are not white, sigmas are widened by the "
        "factor in the last column.",
    )
    return "Validation", (*tables, _whiteness(result)), notes


def _known(value: float) -> float | None:
    return None if np.isnan(value) else value


def _whiteness(result: MotionIdentification) -> Table:
    names = result.arm.joint_names
    rows = [
        (
            names[w.joint - 1],
            "yes" if w.white else "no",
            float(w.autocorrelation[0]),
            w.probability,
            1.0 if w.white else w.inflation,
        )
        for w in result.whiteness
    ]
    headings = (
        Heading("joint"), Heading("white"), Heading("correlation", "", "+.3f"),
        Heading("probability", "", number), Heading("sigma times", "", ".3g"),
    )  # fmt: skip
    return Table("Residuals against white noise", headings, rows)


def bodies_section(result: MotionIdentification) -> tuple[Section, ...]:
    """What consistency costs at each joint, and of how many numbers of a link the log or the table says more."""
    fit = result.consistent
    if fit is None:
        return ()
    names = result.arm.joint_names
    price = Table(
        "Price of bodies, against least squares",
        (Heading("joint"), Heading("torque between the two, RMS", "", number), Heading("noise", "", number)),
        [
            (names[j], _known(float(fit.price.rms[j])), _known(float(result.information.residual_noise[j])))
            for j in range(result.arm.n)
        ],
    )
    rows = []
    for i, link in enumerate(result.arm.chain.links):
        origins = result.origins[len(INERTIAL) * i : len(INERTIAL) * (i + 1)]
        rotor = int(result.columns.rotor_indices[i])
        counts = [origins.count(word) for word in (FROM_LOG, FROM_BOTH, FROM_TABLE)]
        rows.append((link.link, *counts, float(fit.parameters[rotor]), float(fit.sigma[rotor])))
    headings = (
        Heading("link"), *(Heading(word, "", "d") for word in ("from the log", "from both", "from the table")),
        Heading("rotor", "kg m^2", number), Heading("sigma", "kg m^2", number),
    )  # fmt: skip
    lifted = tuple(
        f"No body has the table's values of {result.arm.chain.links[i - 1].link}: the nearest was taken."
        for i in fit.lifted
    )
    held = tuple(f"Held: {name}." for name in fit.constraints)
    return (("Bodies", (price, Table("Of the ten numbers of a link", headings, rows)), (*lifted, *held)),)


def unknown_section(result: MotionIdentification) -> tuple[Section, ...]:
    """Parameters that the logs know only together, and motions that would identify more."""
    names, tables = result.base.statements(), []
    if result.groups:
        rows = [("; ".join(names[i] for i in g.members), g.largest) for g in result.groups[:_MOST]]
        headings = (Heading("parameters"), Heading("largest correlation", "", "+.4f"))
        tables.append(Table(f"Known only together: correlations above {TOGETHER:g}", headings, rows))
    motions = result.missing_motions() if result.identified < result.base.count else ()
    if motions:
        rows_of = [(one.text(names),) for one in motions[:_MOST]]
        tables.append(Table("Motions that would identify more", (Heading("motion"),), rows_of))
    return (("What the logs leave open", tuple(tables), ()),) if tables else ()


def motion_shown(
    result: MotionIdentification, *, unseen: Sequence[Validation] = (), more: Sequence[Section] = (),
    command: str = "lwr-dyn identify motion",
) -> ShownFit:  # fmt: skip
    """What the page shows of a fit.

    Parameters
    ----------
    result : MotionIdentification
    unseen : sequence of Validation
        On logs of their own (`MotionIdentification.validated_on`).
    more : sequence of Section
        Cards at the end, such as what slips of the table the log shows.
    command : str
        What makes the page, for its footer.
    """
    arm, columns, fit = result.arm, result.columns, result.consistent
    parameters = full_parameters(result.information, arm) if fit is None else fit.parameters
    drawn = drawn_fit(result.samples, columns, parameters)
    own, motors = columns.own(arm), columns.transmission is not None
    sigma = None if fit is None else link_parameters(columns, fit.sigma)
    bodies = None if fit is None else result.base.of(fit.parameters)
    sections = [validation_section(result, unseen), *bodies_section(result), *unknown_section(result), *more]
    sections.append(_recordings(result, drawn.left_out, drawn.every))
    return ShownFit(
        arm=arm,
        title=f"Identification of {arm.name}, reading {arm.reading}",
        command=command,
        said=tuple(_sentences(result)),
        figures=tuple(_figures(result)),
        recordings=drawn.recordings,
        noise=result.information.residual_noise,
        before=link_parameters(columns, own),
        after=link_parameters(columns, parameters),
        sigma=sigma,
        speed=drawn.speed,
        friction_torque=drawn.torque,
        friction=columns.friction_of(parameters),
        friction_before=(None,) * arm.n if motors else arm.friction_models(),
        friction_at=tuple(f"motor {j + 1}" for j in range(arm.n)) if motors else arm.joint_names,
        parameters=parameter_rows(result.information, arm, result.states, bodies),
        caption="Base parameters, by least squares",
        notes=tuple(_notes(result)),
        more=tuple(sections),
    )


def _sentences(result: MotionIdentification) -> list[str]:
    rows = np.bincount(result.samples.recording)
    count = int(np.count_nonzero(rows))
    said = [
        f"{result.equations} equations from {len(result.samples)} instants of {count} "
        f"recording{'s' if count > 1 else ''}; condition "
        f"{number(result.condition, 3) if np.isfinite(result.condition) else 'infinite'}."
    ]
    wide = [n for n, x in zip(result.arm.joint_names, result.information.inflation, strict=True) if x > 1.0]
    if wide:
        said.append(f"Residuals of {', '.join(wide)} are not white: sigmas are widened for it.")
    fit = result.consistent
    if fit is not None:
        how = "found from the logs" if fit.chosen else "as given"
        how += "" if fit.rotor_weight == fit.weight else f"; of rotors {100 * fit.rotor_weight**-0.5:.3g} %"
        said.append(
            f"The bodies drawn are as near to the robot's table as the logs allow: expected deviation "
            f"{100 * fit.deviation:.3g} % ({how}); they cost {number(fit.price.chi2, 3)} in chi squared."
        )
    said += [f"By least squares alone, {line}." for line in body_lines(result.bodies)]
    return said


def _figures(result: MotionIdentification) -> list[tuple[str, str]]:
    fit, n = result.consistent, result.arm.n
    found = [("base parameters identified", f"{result.identified} of {result.base.count}")]
    if fit is not None:
        found.append(("links that are bodies", f"{int(fit.physical.sum())} of {n}"))
    unseen = _over_joints([v.held_out if v.consistent is None else v.consistent for v in result.validation])
    measured, model = (_over_joints([getattr(v, key) for v in result.validation]) for key in ("measured", "model"))
    found += [
        ("of unseen torques left, by the result", _share(unseen, measured)),
        ("left by the robot's own data", _share(model, measured)),
    ]
    worst = int(np.nanargmax(result.information.residual_noise))
    found.append((f"noise, largest at {result.arm.joint_names[worst]}", _torque(result, worst)))
    return found


def _share(left: float, measured: float) -> str:
    share = 100.0 * left / measured if measured > 0.0 else float("nan")
    return f"{share:.3g} %" if np.isfinite(share) else "unknown"


def _torque(result: MotionIdentification, joint: int) -> str:
    unit = "N m" if result.arm.chain.links[joint].kind.value == "revolute" else "N"
    return f"{number(float(result.information.residual_noise[joint]), 2)} {unit}"


def _over_joints(values: Sequence[float]) -> float:
    """RMS of RMS values, those that are known."""
    known = [x for x in values if np.isfinite(x)]
    return hypot(*known) / sqrt(len(known)) if known else float("nan")


def _notes(result: MotionIdentification) -> list[str]:
    seen = [f"{state}: {meaning}." for state, meaning in MEANING.items() if state in result.states]
    return [*seen, f"Sigmas: {NOISE_MODEL}."]


def _recordings(result: MotionIdentification, left_out: int, every: int) -> Section:
    samples = result.samples
    rows = []
    for which in np.unique(samples.recording):
        chosen = samples.recording == which
        t, q = samples.t[chosen], samples.q[chosen]
        used = samples.used[chosen]
        rows.append(
            (samples.sources[which], float(t[-1] - t[0]), int(chosen.sum()), int(used.sum()), _still(q, result))
        )
    headings = (
        Heading("recording"), Heading("length", "s", ".4g"), Heading("instants", "", "d"),
        Heading("equations", "", "d"), Heading("joints that stand still"),
    )  # fmt: skip
    notes = ["Equations of joints that are slow, and torques that were cut out, are not used."]
    notes += [f"{left_out} more recordings are fitted and not drawn."] if left_out else []
    notes += [f"Of the longest recording one in {every} instants is drawn."] if every > 1 else []
    return "Recordings", (Table("Recordings", headings, rows),), tuple(notes)


def _still(q: Array, result: MotionIdentification) -> str:
    names = [name for name, span in zip(result.arm.joint_names, np.ptp(q, axis=0), strict=True) if span < 1e-3]
    return ", ".join(names) or "none"
