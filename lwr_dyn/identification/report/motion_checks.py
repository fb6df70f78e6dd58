"""Cards on what a fit to any motion is worth: validation, whiteness, price of bodies, what is known only together."""

from collections.abc import Sequence

import numpy as np

from lwr_dyn.dynamics.regressor import INERTIAL
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.identification.motion.motion_fit import MotionIdentification
from lwr_dyn.identification.motion.motion_tables import validation_table
from lwr_dyn.identification.motion.parameter_states import FROM_BOTH, FROM_LOG, FROM_TABLE, TOGETHER
from lwr_dyn.identification.motion.residuals import LAGS, LEVEL
from lwr_dyn.identification.motion.validation import Validation
from lwr_dyn.identification.report.parameter_rows import number
from lwr_dyn.identification.report.shown_fit import Section

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
