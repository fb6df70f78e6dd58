"""Design of a motion that excites the base parameters of an arm: `design_excitation`; as a document."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.foundation.arrays import Array, freeze_arrays, real_array
from lwr_dyn.foundation.document import Document, Fact, Note, Section
from lwr_dyn.foundation.errors import OptionError, ShapeError
from lwr_dyn.foundation.progress import Report
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.identification.excitation import motion_design, objectives
from lwr_dyn.identification.excitation.motion_limits import Clearance, MotionLimits, clearance_of
from lwr_dyn.identification.excitation.room import ExcitationError, check_room, column_words, near_words
from lwr_dyn.identification.excitation.watch import FOR_STARTS, Ended, SearchWatch
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.model.arm import Arm, caveats_of
from lwr_dyn.model.chain import JointKind
from lwr_dyn.model.run import Motion, repr_html, short_repr

DURATION, HARMONICS, STARTS = 10.0, 5, 2
NOISE = 0.1
"""[N m or N] Standard deviation of a joint's torque, where it is not given."""
LONGEST, MOST_STARTS, MOST_ROWS = 3600.0, 1000, 2_000_000
"""[s] of a motion, starts of a search, rows of a sampled motion."""


@dataclass(frozen=True, slots=True, eq=False)
class Excitation:
    """A designed motion and what it is worth.

    `position_use`, `speed_use`, `torque_use` (n,) are shares of the arm's own limits (of half the travel about its
    middle for positions), NaN where a limit is unknown. Torques are those of the table and of the friction that the arm
    has: none at a joint whose friction is unknown.
    """

    arm: Arm
    columns: TorqueColumns
    motion: objectives.FourierMotion
    objective: objectives.ObjectiveName
    score: objectives.MotionScore
    noise: Array
    """(n,) [N m or N] With which the score weighs the joints."""
    position_use: Array
    speed_use: Array
    torque_use: Array
    clear: float
    """Least distance at `check_rate` beyond the radii [m], at least what was to be kept; infinite without obstacles."""
    nearest: str
    """Between what and what it is."""
    starts: tuple[motion_design.SearchedMotion, ...]
    seconds: float
    column: str
    """What the column is, which links are not held against it, and pairs that keep less; empty where there is none."""
    check_rate: float
    """[Hz] At which limits and distances were checked: 1 kHz, less for more than 200 s."""
    asked: int
    """Starts that were asked for; `starts` are those that were searched."""
    ended: Ended = "searched"
    faults: tuple[str, ...] = ()
    """Why it may not be run, in words: what is too near, joints whose torque is too large."""
    __repr__, _repr_html_ = short_repr, repr_html

    @property
    def document(self) -> Document:
        """The result for people and programs."""
        return _document(self)

    def __post_init__(self) -> None:
        freeze_arrays(self, "noise", "position_use", "speed_use", "torque_use")

    def sampled(self, rate: float = 100.0) -> Motion:
        """The motion at `rate` [Hz] from 0 to its end; raises `OptionError` as `check_rate`."""
        check_rate(rate, self.motion.duration)
        return self.motion.sample(np.arange(round(self.motion.duration * rate) + 1) / rate)


def design_excitation(
    arm: Arm,
    duration: float = DURATION,
    objective: objectives.ObjectiveName = "d",
    starts: int = STARTS,
    harmonics: int = HARMONICS,
    seed: int = 0,
    *,
    noise: ArrayLike = NOISE,
    limits: MotionLimits | None = None,
    clearance: Clearance | None = None,
    columns: TorqueColumns | None = None,
    seconds: float = math.inf,
    stop: Callable[[], bool] = lambda: False,
    better: Callable[[Excitation], None] = lambda _: None,
    report: Report = lambda _: None,
) -> Excitation:
    """A motion from rest to rest, the best of several starts, whose torques say most of the arm's base parameters.

    Parameters
    ----------
    arm : Arm
        With its payload, tool and mount; its table is used for torques against limits only.
    duration : float
        [s]
    objective : {"d", "cond"}
        -log det of the weighted information per parameter, or the condition number of the scaled columns.
    starts : int
        Random motions from which the search begins.
    harmonics : int
        Of 1 / duration.
    seed : int
        The same seed gives the same motion on the same machine.
    noise : float or (n,) array_like
        [N m or N] Standard deviation of each joint's torque: the weights.
    limits : MotionLimits, optional
        `MotionLimits.of(arm)` if not given.
    clearance : Clearance, optional
        `clearance_of(arm)` if not given.
    columns : TorqueColumns, optional
        The parameters to excite: bodies, rotors and symmetric friction, of this chain or another geometry.
    seconds : float
        [s] Of the search: where they are over, the best motion so far is the result.
    stop : function
        Whether the search is asked to end so at once; asked at each step of it.
    better : function of Excitation
        Called with each motion that may be run and is better than those before, as soon as it is found.
    report : function of float or str
        Called with the share that is done and with the step that begins.

    Raises
    ------
    OptionError, ShapeError
        Numbers out of their range, noise of another shape, columns with other friction or a transmission.
    MissingDataError, MissingPackageError
        An arm without masses; the extra `batch` is not installed.
    ExcitationError
        No pose meets what is asked, which is seen before any search: says which pair or joint.
    NoMotionError
        No start ended clear and inside the limits; has the motion that comes nearest to it.

    References
    ----------
    Swevers et al., Optimal robot excitation and identification (1997); Park, Fourier-based optimal excitation
    trajectories for the dynamic identification of robots (2006).
    """
    watch = SearchWatch(check_seconds(seconds), stop, report, steps=starts + motion_design.POLISHED)
    check_choices(objective, starts, seed, duration)
    design = motion_design.MotionDesign(
        arm, duration, harmonics, objective, noise_of_joints(noise, arm.n),
        columns or TorqueColumns(arm.require_dynamics()), limits or MotionLimits.of(arm),
        clearance or clearance_of(arm), watch,
    )  # fmt: skip
    check_room(design.clearance, design.limits, design.torques)
    found: list[motion_design.SearchedMotion] = []
    for i in range(starts):
        if found and watch.is_over(FOR_STARTS):
            break
        watch.step(f"start {i + 1} of {starts}")
        found.append(design.start(np.random.default_rng([seed, i])))
        if found[-1].good and found[-1] is motion_design.best_motion(found):
            better(_excitation(design, found[-1], found, starts))
    best = _excitation(design, design.best_of(found), found, starts)
    if best.faults:
        raise NoMotionError(best)
    return best


class NoMotionError(ExcitationError):
    """A search ended in no motion that may be run: `best` is the one that comes nearest to it."""

    def __init__(self, best: Excitation) -> None:
        words = f"in the best of {_starts(best)} {'; '.join(best.faults)}"
        super().__init__(f"excitation of {best.arm.name}", words, "more starts, a longer motion, less to keep")
        self.best = best


def _excitation(
    design: motion_design.MotionDesign, best: motion_design.SearchedMotion,
    found: list[motion_design.SearchedMotion], asked: int,
) -> Excitation:  # fmt: skip
    """What one of the motions that were found is worth."""
    arm, motion, states = design.arm, design.check.motion(best.X), design.states(best.X)
    lower, upper = (np.where(np.isinf(x), np.nan, x) for x in (arm.lower, arm.upper))
    aside = np.abs(states[0] - (lower + upper) / 2.0).max(axis=0)
    distances = (design.clearance.of(states[0]) + design.clearance.keeps).min(axis=0, initial=np.inf)
    place = int(np.argmin(distances)) if distances.size else 0
    clear = float(distances.min(initial=np.inf))
    return Excitation(
        arm, design.columns, motion, design.objective,
        objectives.motion_score(design.columns, rows_of(motion), design.noise), design.noise,
        aside / ((upper - lower) / 2.0), _share(np.abs(states[1]).max(axis=0), arm.velocity),
        _share(np.abs(design.torques.torque(*states)).max(axis=0), arm.effort), clear,
        design.clearance.names[place] if distances.size else "", tuple(found),
        design.watch.elapsed, _words_of(design.clearance), design.check_rate, asked, design.watch.ended,
        design.faults(best.X),
    )  # fmt: skip


def _words_of(clearance: Clearance) -> str:
    return "; ".join(words for words in (column_words(clearance), near_words(clearance)) if words)


def _starts(found: Excitation) -> str:
    """How many starts were searched, in words."""
    return "1 start" if len(found.starts) == 1 else f"{len(found.starts)} starts"


def rows_of(motion: objectives.FourierMotion, rate: float = objectives.SCORE_RATE) -> Motion:
    """The motion at `rate` [Hz], each instant of its period once."""
    return motion.sample(np.arange(max(1, round(motion.duration * rate))) / rate)


def check_choices(objective: str, starts: int, seed: int, duration: float = DURATION) -> None:
    """Raise `OptionError` for an objective that does not exist, numbers that are not whole, or out of their range."""
    if objective not in objectives.OBJECTIVES:
        raise OptionError("objective", repr(objective), ", ".join(objectives.OBJECTIVES))
    if not 0.0 < duration <= LONGEST:
        raise OptionError("duration", duration, f"a time above 0 s, at most {LONGEST:g} s")
    for name, value, least, most in (("starts", starts, 1, MOST_STARTS), ("seed", seed, 0, np.inf)):
        if isinstance(value, bool) or not isinstance(value, int) or not least <= value <= most:
            upto = f" to {most:g}" if np.isfinite(most) else ""
            raise OptionError(name, repr(value), f"a whole number from {least}{upto}")


def check_seconds(seconds: float) -> float:
    """The time of a search [s]; raises `OptionError` where it is not above 0."""
    if not seconds > 0.0:
        raise OptionError("seconds", seconds, "above 0, in s; inf for no limit")
    return seconds


def check_rate(rate: float, duration: float) -> None:
    """Raise `OptionError` for a rate [Hz] that is not above 0, or that makes more than `MOST_ROWS` rows."""
    if not 0.0 < rate <= MOST_ROWS / duration:
        raise OptionError("rate", rate, f"above 0, at most {MOST_ROWS / duration:g} Hz for {duration:g} s")


def noise_of_joints(noise: ArrayLike, n: int) -> Array:
    """One standard deviation per joint, (n,); raises `ShapeError`, `OptionError`."""
    given = real_array("noise", noise)
    if given.shape not in ((), (n,)):
        raise ShapeError("noise", f"shape {given.shape}", f"one number, or {n}, one per joint")
    if not (given > 0.0).all():
        raise OptionError("noise", float(given.min()), "above 0, in N m or N")
    return np.array(np.broadcast_to(given, (n,)))


def _share(used: Array, limit: Array) -> Array:
    return np.where(np.isinf(limit), np.nan, used / limit)


KINDS = {name: "first moments" for name in ("mx", "my", "mz")}
KINDS |= {name: "tensors" for name in ("Ixx", "Ixy", "Ixz", "Iyy", "Iyz", "Izz")} | {"m": "masses"}
"""The kind of a column of a body; columns of joints are their own kind."""


def _document(found: Excitation) -> Document:
    """What the motion shows, how it uses the limits, and the parameters that are known least."""
    arm, motion, score = found.arm, found.motion, found.score
    clear = f"at least {found.clear:.3f} m between {found.nearest}" if found.nearest else "nothing to keep clear of"
    rate = min(motion_design.CHECK_RATE, motion_design.MOST_CHECKS / motion.duration)
    checked = "1 kHz" if rate == motion_design.CHECK_RATE else f"{rate:.3g} Hz"
    facts = [
        Fact("robot", arm.name, "Name of the robot."), Fact("reading", arm.reading, "Its reading.", kind=str),
        Fact("duration", motion.duration, "s."), Fact("harmonics", len(motion.sines), "Of one over the duration."),
        Fact("objective", found.objective, "What was minimised.", kind=Literal["d", "cond"]),
        Fact("noise", found.noise, "Standard deviation of each joint's torque."),
        Fact("seconds", found.seconds, "Time of the search."),
        Fact("ended", found.ended, "Whether all that was asked was searched, its time was over, or it was stopped.",
             kind=Literal["searched", "seconds", "stopped"]),
        Fact("may_be_run", not found.faults, "Whether it is clear and inside the limits; if not, the exit code is 1."),
    ]  # fmt: skip
    whole = Section("", [
        Note(found.faults, bool(found.faults), "faults", "Why not to run it.", before="DO NOT RUN IT: "),
        Note(ended_words(found), found.ended != "searched"),
        Fact("d", score.d, "-log det of the weighted information of one row, per base parameter.",
             "-log det of the information per parameter",
             format=lambda d: f"{d:.3f} ({len(score.sigma)} base parameters)"),
        Fact("mean_sigma", score.mean_sigma, "Geometric mean of the sigmas of the base parameters.",
             "geometric mean of their sigmas", "(SI)", ".3g"),
        Fact("condition", score.condition, "Condition number of the regressor, its columns scaled to length 1.",
             "condition number of the scaled columns", "", ".2f"),
        Fact("check_rate", found.check_rate, "Of the instants at which limits and distances are checked, Hz."),
        Fact("clearance", found.clear,
             "Least distance at the instants of the check beyond the radii; null without obstacles.",
             f"checked at {checked}", format=lambda _: clear),
        Fact("nearest", found.nearest, "Between what."),
        Note(f"no torque tells these apart, only their sums: {', '.join(score.together)}", bool(score.together)),
        Note(found.column, bool(found.column)),
    ])  # fmt: skip
    series = Section("", [
        Fact("centre", motion.centre), Fact("sines", motion.sines), Fact("cosines", motion.cosines),
    ], "series",
        "q = centre + sum sines / (k w) sin(k w t) - cosines / (k w) cos(k w t), w = 2 pi / duration.")  # fmt: skip
    starts = [(one.value, one.clear, one.seconds) for one in found.starts]
    searched = Table("", (
        Heading(key="value", says="The objective; of cond the log."),
        Heading(key="clearance", says="Less what is kept.", kind=float), Heading(key="seconds"),
    ), starts, key="starts", says="Where the search ended from each random motion.")  # fmt: skip
    title = (
        f"{arm.name}, reading {arm.reading}: {motion.duration:g} s at rest at both ends, {len(motion.sines)} harmonics"
        f", objective {found.objective}, best of {_starts(found)} in {found.seconds:.1f} s"
    )
    rows = zip(score.names, found.columns.base().statements(), own_values(found), score.sigma, strict=True)
    parameters = Table("", (
        Heading(key="name"), Heading(key="combination", says="Of the parameters of links and joints."),
        Heading(key="table", says="Its value in the arm's table."),
        Heading(key="sigma", says="What noise leaves of it."),
    ), [*rows], key="parameters", says="The base parameters.")  # fmt: skip
    parts = [[use_table(found)], [sigma_table(found), parameters], [searched]]
    sections = [whole, series, *(Section("", part) for part in parts)]
    return Document(title, "", sections, "lwr-dyn excite", "excitation", facts, caveats_of([arm]))


def ended_words(found: Excitation) -> str:
    """Why the search ended before all was searched, and how far it came."""
    why = "stopped" if found.ended == "stopped" else "its time was over"
    return f"ended early ({why}): {len(found.starts)} of {found.asked} starts searched; the best motion so far"


def use_table(found: Excitation) -> Table:
    """Range and use of the limits, joint by joint."""
    q = found.sampled().q
    rows = []
    for j, link in enumerate(found.arm.chain.links):
        factor, unit = (180.0 / np.pi, "deg") if link.kind is JointKind.REVOLUTE else (1.0, "m")
        low, high = factor * q[:, j].min(), factor * q[:, j].max()
        use = [x[j] for x in (found.position_use, found.speed_use, found.torque_use)]
        rows.append((link.joint, f"{low:.4g} to {high:.4g} {unit}", *use))
    head = [Heading("joint"), Heading("from, to", key=None)]
    for name in ("position", "speed", "torque"):
        head.append(Heading(name, format=lambda x: "unknown" if np.isnan(x) else f"{100.0 * x:.0f} %", kind=float))
    says = (
        "Shares of the arm's own limits that are used; null where a limit is unknown. Torques have the friction that "
        "the arm's file gives, none where it gives none."
    )
    return Table("Use of the arm's limits", head, rows, without_friction(found.arm), "joints", says)


def without_friction(arm: Arm) -> str:
    """What the torques leave out, in words; empty where every joint's friction is known."""
    models = zip(arm.joint_names, arm.friction_models(), strict=True)
    names = [name for name, model in models if model is None]
    of = "" if len(names) == arm.n else f" of {', '.join(names)}"
    return f"torques without friction{of}, which the arm's file does not give: keep room for it" if names else ""


def sigma_table(found: Excitation) -> Table:
    """What noise leaves of the base parameters, kind by kind, and the one of each kind that is known least."""
    sigma, own, names = found.score.sigma, np.abs(own_values(found)), found.score.names
    kinds = np.array([KINDS.get(name.split("_")[0], name.split("_")[0]) for name in names])
    rows = []
    for kind in dict.fromkeys(kinds.tolist()):
        of_kind = np.flatnonzero(kinds == kind)
        worst = of_kind[int(np.argmax(sigma[of_kind]))]
        rows.append((kind, len(of_kind), np.median(sigma[of_kind]), sigma[worst], names[worst], own[of_kind].max()))
    head = (
        Heading("base parameters"), Heading("number"), Heading("median sigma", "SI", ".2g"),
        Heading("largest", "SI", ".2g"), Heading("of"), Heading("largest in the table", "SI", ".2g"),
    )  # fmt: skip
    noise = ", ".join(f"{x:g}" for x in dict.fromkeys(found.noise.tolist()))
    title = f"Sigma from torque noise of {noise} N m, {objectives.SCORE_RATE:g} rows a second"
    return Table(title, head, rows, "--json has all of them")


def own_values(found: Excitation) -> Any:
    """The base parameters (b,) of the arm's own table and friction."""
    return found.columns.base().of(found.columns.own(found.arm))
