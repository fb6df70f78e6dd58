"""What a fit to any motion found, for programs and people: what is identified and what cannot be, bodies, and what is
left of torques that it did not see.
"""

from collections.abc import Iterable, Sequence
from dataclasses import astuple, dataclass, field, replace
from typing import Any, Literal, get_args

import numpy as np

from lwr_dyn.dynamics.regressor import INERTIAL
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.document import Document, Fact, Note, Section
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.identification.bodies.consistent import ConsistentFit
from lwr_dyn.identification.bodies.possible_bodies import LONGEST, BodyVerdict, body_lines, body_parts, short
from lwr_dyn.identification.logs.joint_log import JointLog
from lwr_dyn.identification.motion import identifiable, validation
from lwr_dyn.identification.motion.friction_rows import friction_parts
from lwr_dyn.identification.motion.gain_fit import gain_parts
from lwr_dyn.identification.motion.load_hint import LoadHint
from lwr_dyn.identification.motion.validation import Validation, Whiteness
from lwr_dyn.identification.regression.drive_gains import DriveGains
from lwr_dyn.identification.regression.information import Information
from lwr_dyn.identification.regression.joints_alone import motor_words
from lwr_dyn.identification.regression.least_squares import IDENTIFIED, BaseParameters
from lwr_dyn.identification.regression.samples import DEFAULT_SAMPLES, SampleRule, Samples, samples_of
from lwr_dyn.identification.regression.stribeck import StribeckSearch
from lwr_dyn.identification.regression.torque_columns import FrictionForm, TorqueColumns
from lwr_dyn.model.arm import Arm, caveats_of
from lwr_dyn.model.run import repr_html, short_repr

Numbers = list[float]
Origin = Literal["log", "log and table", "table"]
NOISE_MODEL = (
    "the errors are those of noise, widened where residuals of neighbouring instants are alike; friction that the "
    "columns lack makes the true ones larger"
)
WITHOUT_PARTS = (
    "instrumental variables on unfiltered rows: no part of the motion was kept from the fit, and the price is that "
    "along the command; judge the fit on other logs with --validate"
)
AT_MOTORS = "rotors and friction are those of motors, each seen at the joint of its number"
LARGEST_DEVIATION = 10.0  # beyond, the table says nothing and leaves no bodies
LARGEST_GAIN = 0.5  # beyond, a gain is unknown
EXACT = 1e-6  # of a torque: residuals below it are those of a log that was computed and has no noise


@dataclass(frozen=True, slots=True, eq=False)
class MotionRule:
    """How parameters are taken from logs.

    Parameters
    ----------
    samples : SampleRule
        How instants are taken; with a transmission rotors and friction are those of the motors.
    friction : {"directions", "symmetric"}
        Coulomb and viscous friction of each direction, or the same in both with an offset.
    stribeck : bool
        Whether Stribeck speeds are searched, on all motions; take samples at low speeds then.
    load_friction : bool
        Whether friction grows with the torque that a gear carries, a share of it a joint (`regression.load_friction`).
    folds : int
        Parts into which the motions are dealt; each is kept from a fit in turn.
    deviation : float, optional
        Relative deviation of the arm from its table that is expected, such as 0.2; that of most evidence if not given.
    cutoffs : tuple of float
        Filters on positions [Hz], of which the log's likeliest is taken in place of that of `samples`, on its positions
        or its own speeds (`likeliest_samples`); none for `samples` as they are.
    known : tuple of str
        What is known for certain of the bodies, as `total mass = 15.8` or `m_7 = 0.24` (`constraints_of`).
    gains : float, optional
        Share to which the gains of the torques are known, such as 0.1: a factor a joint is fitted, log-normal about 1.
    coupled : bool, optional
        Whether rotors and friction are those of motors that turn several joints (`regression.coupled_motors`); by
        the log if not given, and not with `gains` or `load_friction`.

    Raises
    ------
    OptionError
        A deviation that is not above 0 or beyond `LARGEST_DEVIATION`; fewer than two folds; gains that are not above 0
        or beyond `LARGEST_GAIN`; those, or friction with the load, of motors that turn joints together.
    """

    samples: SampleRule = DEFAULT_SAMPLES
    friction: FrictionForm = "directions"
    stribeck: bool = False
    load_friction: bool = False
    folds: int = 5
    deviation: float | None = None
    known: tuple[str, ...] = ()
    cutoffs: tuple[float, ...] = ()
    gains: float | None = None
    coupled: bool | None = None

    def __post_init__(self) -> None:
        if self.folds < 2:
            raise OptionError("folds", self.folds, "a number of at least 2")
        if self.deviation is not None and not (0.0 < self.deviation <= LARGEST_DEVIATION):
            allowed = f"a share above 0 and up to {LARGEST_DEVIATION:g}, such as 0.2 for 20 %"
            raise OptionError("deviation", self.deviation, allowed)
        if self.gains is not None and not (0.0 < self.gains <= LARGEST_GAIN):
            raise OptionError("gains", self.gains, f"a share above 0 and up to {LARGEST_GAIN:g}, such as 0.1 for 10 %")
        motors, asked = self.samples.transmission, "gains" if self.gains is not None else "load friction"
        if motors is not None and motors.coupled.any() and (self.gains is not None or self.load_friction):
            raise OptionError(asked, "given for motors that turn joints together", "motors with a joint each")

    def columns(self, arm: Arm) -> TorqueColumns:
        """Of an arm, without Stribeck speeds and friction with the load."""
        rule = self.samples
        return TorqueColumns(arm.chain, self.friction, transmission=rule.transmission, link_side=rule.link_side)


DEFAULT_MOTION = MotionRule()


@dataclass(frozen=True, slots=True, eq=False)
class MotionIdentification:
    """Base parameters with their errors, bodies that have them, and how well both predict torques they did not see."""

    arm: Arm
    rule: MotionRule
    samples: Samples = field(repr=False)
    information: Information
    """What the logs say of the base parameters."""
    consistent: ConsistentFit | None
    """Bodies, rotors and friction near the arm's table; None for an arm without masses."""
    of_the_model: Array
    """Values from the arm's own inertias and friction for the base parameters (b,)."""
    validation: tuple[Validation, ...]
    """One a joint, over motions kept from the fit in turn."""
    whiteness: tuple[Whiteness, ...]
    """Of the residuals of every joint that moved."""
    groups: tuple[identifiable.CorrelatedGroup, ...]
    bodies: BodyVerdict
    """Whether no bodies can have the values of least squares."""
    stribeck: StribeckSearch | None = None
    """The search for Stribeck speeds, where one was asked for."""
    stribeck_sigma: Array | None = None
    """Their standard errors (n,) [rad/s or m/s], NaN for a joint without one."""
    gains: DriveGains | None = None
    """Of the torques, where they were fitted: `samples` have the torques of the logs over them."""
    load_hint: LoadHint | None = None
    """What friction that grows with the load would gain, where it was not fitted and the log asks for it."""
    __repr__ = short_repr
    _repr_html_ = repr_html

    @property
    def document(self) -> Document:
        """The fit for people and programs, without logs of their own."""
        return motion_document(self)

    @property
    def columns(self) -> TorqueColumns:
        """Of the torques."""
        return self.information.columns

    @property
    def base(self) -> BaseParameters:
        """Which combinations are determined."""
        return self.information.base

    @property
    def half_widths(self) -> Array:
        """Of the 3-sigma intervals of the base parameters (b,)."""
        return self.information.half_widths

    @property
    def states(self) -> tuple[str, ...]:
        """Of each base parameter: identified, or why not (`parameter_states.MEANING`)."""
        return identifiable.parameter_states(self.information, self.of_the_model)

    @property
    def identified(self) -> int:
        """How many base parameters are identified."""
        return self.states.count(IDENTIFIED)

    @property
    def condition(self) -> float:
        """Of the columns scaled to length 1; above a few hundred the motion excites some parameters poorly."""
        return self.information.condition

    @property
    def equations(self) -> int:
        """How many were used."""
        return int(self.information.equations.sum())

    @property
    def origins(self) -> tuple[str, ...]:
        """Of each parameter of the consistent fit (p,): whether the log or the table says more of it."""
        if self.consistent is None:
            return ()
        return identifiable.cell_origins(self.consistent.left)

    @property
    def contradiction(self) -> str:
        """By what the log contradicts the bodies near the table, in words; empty where chance explains it."""
        if self.consistent is None or not self.consistent.price.refused:
            return ""
        price = self.consistent.price
        name = short(self.base.statements()[price.parameter])
        said = f"{name} is {price.pull:.1f} sigma off, chi^2 {price.chi2:.4g}, probability {price.probability:.1g}"
        if not self.has_noise:
            said += (
                "; the log has no noise, so that sigma is rounding and next to nothing is many of it: by torques the "
                f"bodies miss the log by {np.nanmax(price.rms):.1g} N m (N) RMS at most; give the torques a sensor's "
                "noise, or accept the bodies"
            )
        return said

    @property
    def has_noise(self) -> bool:
        """Whether some joint's residuals are more than rounding, `EXACT` of its torques."""
        normal = self.information.normal
        seen = normal.equations > 0
        least = EXACT * np.sqrt(normal.squares[seen] / normal.equations[seen])
        return bool((self.information.residual_noise[seen] > least).any())

    @property
    def shown_sigma(self) -> tuple[float | None, ...]:
        """Standard errors of the consistent fit (p,), None where the number is that of the table."""
        if self.consistent is None:
            return ()
        pairs = zip(self.consistent.sigma.tolist(), self.origins, strict=True)
        return tuple(None if origin == identifiable.FROM_TABLE else sigma for sigma, origin in pairs)

    def missing_motions(self) -> tuple[identifiable.MissingMotion, ...]:
        """Swings that would identify what this motion does not."""
        wanted = [i for i, state in enumerate(self.states) if state != IDENTIFIED]
        return identifiable.missing_motions(self.information, self.arm, wanted)

    def residuals(self) -> Array:
        """Measured torques less those of the fit, (k, n) [N m or N], NaN where not used."""
        return validation.residuals_of(self.samples, self.columns, self.information.values)

    def validated_on(self, logs: Iterable[JointLog]) -> tuple[Validation, ...]:
        """The same figures on logs that the fit has not seen; raises `LogError` as `identify_motion`."""
        parameters = None if self.consistent is None else self.consistent.parameters
        several = list(logs)
        samples = samples_of(several, self.rule.samples)
        if self.gains is not None:
            samples = samples.times(1.0 / self.gains.values)
        known = samples_of(several, self.rule.samples.taking_all()).used
        values, own = self.information.values, self.columns.own(self.arm)
        return validation.validated_on(samples, known, self.columns, values, own, parameters)


def motion_document(
    result: MotionIdentification, *, robot: str = "", unseen: Sequence[Validation] = (), files: str = ""
) -> Document:
    """The fit; `unseen` are its figures on logs of their own, `files` their names."""
    arm, found, fit, judged = result.arm, result.information, result.consistent, validation.validation_table
    columns, hint = result.columns, result.load_hint
    turned = motor_words(columns.transmission)
    contradicted = f"THE LOG CONTRADICTS THE BODIES NEAR THE TABLE: {result.contradiction}; "
    verdict = contradicted * bool(result.contradiction) + (
        f"{result.identified} of {result.base.count} base parameters identified, from {result.equations} equations, "
        f"condition {result.condition:.3g}"
    )
    names = [short(name) for name in result.base.statements()]
    kept = f"{result.rule.folds} parts of the motion, each kept from a fit in turn"
    seen = f"{files or 'logs'}, which no fit has seen"
    facts = [
        Fact("robot", robot, "Name of the robot."),
        Fact("equations", result.equations, "How many were used."),
        Fact("condition", float(result.condition), "Of the scaled regressor."),
        Fact("base_parameters", result.base.count, "How many there are."),
        Fact("identified", result.identified, "How many of them are identified."),
        Fact("noise_model", NOISE_MODEL, "What the errors are."),
        Fact("noise", found.residual_noise, "Standard deviation of each joint's torques.", kind=Numbers),
        Fact("inflation", found.inflation, "How much larger the noise counts where residuals of neighbouring instants "
             "are alike, 1 where they are white.", kind=Numbers),
        Fact("chi2", found.chi2, "Of the residuals."), Fact("dof", found.dof, "Equations less parameters."),
        Fact("coupled", bool(turned), "Whether rotors and friction are those of motors that turn several joints."),
        Fact("folds", result.rule.folds, "Parts of the motion, each kept from a fit in turn."),
        Fact("load_friction_gain", None if hint is None else hint.gain, "Share of what is left of unseen torques that "
             "friction with the load would explain; null where it is fitted or chance does.", kind=float | None),
    ]  # fmt: skip
    sections = [
        Section("", [
            Note(f"{turned}: {AT_MOTORS}", bool(turned)),
            Note("NO BODIES CAN HAVE THESE VALUES", result.bodies.impossible),
            Note("sigma widened: residuals are not white", bool((found.inflation > 1.0).any())),
            Note("" if hint is None else hint.words, hint is not None),
            Note(WITHOUT_PARTS, not result.validation),
            Note(body_lines(result.bodies)),
        ]),
        Section("Bodies", body_parts(result.bodies), key="bodies", says="Whether bodies can have the values."),
        Section("Parameters", [
            parameters(result), *(Note(f"{s}: {m}", s in result.states) for s, m in identifiable.MEANING.items()),
            *friction_parts(found, result.states, result.stribeck, result.stribeck_sigma),
        ]),
        Section("Gains", gain_parts(result.gains, fit), key="gains", there=result.gains is not None,
                says="Gains of the torques that were fitted; null where they are taken as known."),
        Section("What the logs leave open", [
            identifiable.together(result.groups, names), identifiable.missing(result.missing_motions(), names),
        ]),
        Section("Bodies near the table", _consistent(result), key="consistent", there=fit is not None,
                says="Bodies, rotors and friction near the robot's table; null for a robot without masses."),
        Section("Links", [] if fit is None else [links(result)]),
        Section("Validation", [
            judged(result.validation, kept, "validation", "RMS torques of each joint that are left."),
            validation.whiteness_table(result.whiteness),
        ], brief=True),
        Section("Validation on other logs", [
            judged(unseen, seen, "validated_on", "The same as `validation` on logs that no fit has seen."),
        ]),
    ]  # fmt: skip
    return Document(f"Identification of {arm.name}, reading {arm.reading}", verdict, sections,
                    "lwr-dyn identify motion", "identification", facts,
                    caveats_of([replace(arm, transmission=None) if columns.transmission else arm]))  # fmt: skip


def parameters(result: MotionIdentification) -> Table:
    """One row a base parameter."""
    found, fit, own = result.information, result.consistent, result.of_the_model
    bodies = np.full(own.size, np.nan) if fit is None else result.base.of(fit.parameters)
    sigma = np.where((found.sigma > 0.0) & (found.sigma < np.inf), found.sigma, np.nan)
    identified = [state == IDENTIFIED for state in result.states]
    columns = (
        Heading("parameter (SI)", key="parameter", cut=LONGEST), Heading("value", key="value", sigma="standard_error"),
        Heading(key="standard_error", says="Null where the motion does not show the parameter."),
        Heading(key="three_sigma", says="Half width of the interval of 99.73 %."),
        Heading("by bodies", format=".5g", key=None, page=True, says="Of the bodies near the table."),
        Heading("of the model", format=".5g", key="of_the_model"), Heading(key="identified"),
        Heading("value less table", "sigma", ".2g", None, page=True, bar=10.0),
        Heading("state", key="state", pick=True),
    )  # fmt: skip
    rows = zip(result.base.statements(), found.values, found.sigma, result.half_widths, bodies, own, identified,
               (found.values - own) / sigma, result.states, strict=True)  # fmt: skip
    return Table("", columns, [*rows], f"value +- standard error; {NOISE_MODEL}", "parameters")


def expected(fit: ConsistentFit) -> str:
    """How far links are expected off the table, in words, and who says so."""
    s, chosen = fit.scales, "found from the logs" if fit.chosen else "as given"
    return (
        f"masses {s.mass:.2g}, centres {1e3 * s.centre:.2g} mm, tensors {s.tensor:.2g}, shapes {s.shape:.2g}, rotors "
        f"{s.rotor:.2g} ({chosen})"
    )


def _consistent(result: MotionIdentification) -> list[Any]:
    fit = result.consistent
    if fit is None:
        return []
    own, rms = result.columns.own(result.arm), fit.price.rms
    columns = (Heading(key="parameter"), Heading(key="value"), Heading(key="standard_error", kind=float | None,
               says="Null where the number is that of the table: no torque shows it."),
               Heading(key="of_the_model"), Heading(key="says", kind=Origin))  # fmt: skip
    rows = zip(result.columns.names, fit.parameters, result.shown_sigma, own, result.origins, strict=True)
    lifted = ", ".join(map(str, fit.lifted))
    return [
        Fact("physical", [bool(x) for x in fit.physical], "Which links are bodies.", "bodies near the table",
             format=lambda links: f"{sum(links)} of {len(links)} links are bodies"),
        Fact("scales", [*astuple(fit.scales)], "Expected off the table: share of shapes, length of centres [m], shares "
             "of tensors and masses, the spread of the logs of rotors.", "expected off the table",
             format=lambda _: expected(fit), kind=Numbers),
        Fact("scales_chosen", bool(fit.chosen), "Whether they were found from the logs."),
        Fact("price_chi2", fit.price.chi2, "Against least squares.", "price against least squares, chi^2", "", "+.3g"),
        Fact("price_rms", rms, "Of the torque between the two.", "price against least squares, RMS at the worst joint",
             "N m (N)", lambda x: f"{np.nanmax(x):.2g}", Numbers),
        Fact("pull", fit.price.pull, "Of the base parameter furthest from least squares, in standard errors.",
             "furthest from least squares", "sigma", ".1f"),
        Fact("probability", fit.price.probability, "That chance gives so large a pull or chi^2; below 0.001 the log "
             "contradicts the bodies."),
        Fact("contradiction", result.contradiction, "By what; empty where it does not."),
        Fact("lifted", list(fit.lifted), "Links whose values in the table no body has.", kind=list[int]),
        Fact("known", list(fit.constraints), "What was given as known.", kind=list[str]),
        Table("", columns, [*rows], key="parameters"),
        Note(f"known: {'; '.join(fit.constraints)}", bool(fit.constraints)),
        Note(f"no body has the table's values of link {lifted}: the nearest was taken", bool(fit.lifted)),
    ]  # fmt: skip


def links(result: MotionIdentification) -> Table:
    """One row a link of the consistent fit: mass, centre of mass, rotor, and how much of it the log says."""
    fit, own, origins = result.consistent, result.columns.own(result.arm), result.origins
    assert fit is not None
    shown, rows = result.shown_sigma, []
    for i, rotor in enumerate(result.columns.rotor_indices):
        ten = slice(len(INERTIAL) * i, len(INERTIAL) * (i + 1))
        found = fit.parameters[ten]
        counts = [origins[ten].count(word) for word in get_args(Origin)]
        rows.append((str(i + 1), found[0], shown[10 * i], own[ten][0], found[1:4] / found[0], fit.parameters[rotor],
                     shown[rotor], *counts))  # fmt: skip
    columns = (
        Heading("link"), Heading("mass", "kg", sigma="sigma_m", without=identifiable.FROM_TABLE),
        Heading(key="sigma_m"),
        Heading("of the model", "kg", ".5g"),
        Heading("centre of mass", "m", lambda com: ", ".join(f"{x:.4g}" for x in com)),
        Heading("rotor", "kg m^2", sigma="sigma_r", without=identifiable.FROM_TABLE), Heading(key="sigma_r"),
        Heading("log"), Heading("both"), Heading("table"),
    )  # fmt: skip
    note = (
        "log, both, table: of a link's ten numbers, how many each says more of; table in place of a plus-minus: no "
        "torque shows the number"
    )
    return Table("", columns, rows, note)
