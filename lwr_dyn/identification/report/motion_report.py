"""A fit to any motion (`identify_motion`) as the report shows it: head figures, bodies, checks, recordings."""

from collections.abc import Sequence
from math import hypot, sqrt

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.identification.motion.motion_fit import MotionIdentification
from lwr_dyn.identification.motion.motion_tables import NOISE_MODEL, body_lines
from lwr_dyn.identification.motion.parameter_states import MEANING
from lwr_dyn.identification.motion.validation import Validation
from lwr_dyn.identification.report.fit_values import drawn_fit, full_parameters, link_parameters, parameter_rows
from lwr_dyn.identification.report.motion_checks import bodies_section, unknown_section, validation_section
from lwr_dyn.identification.report.parameter_rows import number
from lwr_dyn.identification.report.shown_fit import Section, ShownFit


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
