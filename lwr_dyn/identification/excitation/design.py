"""Design of a motion that excites the base parameters of an arm: `design_excitation`."""

from collections.abc import Callable
from dataclasses import dataclass
from time import perf_counter

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.foundation.arrays import Array, freeze_arrays, real_array
from lwr_dyn.foundation.errors import OptionError, ShapeError
from lwr_dyn.identification.excitation.clearance import Clearance, clearance_of
from lwr_dyn.identification.excitation.fourier import FourierMotion
from lwr_dyn.identification.excitation.motion_design import MotionDesign, SearchedMotion, StartSummary
from lwr_dyn.identification.excitation.motion_limits import MotionLimits
from lwr_dyn.identification.excitation.motion_score import SCORE_RATE, MotionScore, motion_score
from lwr_dyn.identification.excitation.objectives import OBJECTIVES, ObjectiveName
from lwr_dyn.identification.excitation.room import check_room, column_words
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Motion
from lwr_dyn.model.shown import short_repr

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
    motion: FourierMotion
    objective: ObjectiveName
    score: MotionScore
    noise: Array
    """(n,) [N m or N] With which the score weighs the joints."""
    position_use: Array
    speed_use: Array
    torque_use: Array
    clear: float
    """Least distance at `check_rate` beyond the radii [m], at least what was to be kept; infinite without obstacles."""
    nearest: str
    """Between what and what it is."""
    starts: tuple[StartSummary, ...]
    seconds: float
    column: str
    """What the column is and which links are not held against it; empty without one."""
    check_rate: float
    """[Hz] At which limits and distances were checked: 1 kHz, less for more than 200 s."""
    __repr__ = short_repr

    def __post_init__(self) -> None:
        freeze_arrays(self, "noise", "position_use", "speed_use", "torque_use")

    def sampled(self, rate: float = 100.0) -> Motion:
        """The motion at `rate` [Hz] from 0 to its end; raises `OptionError` as `check_rate`."""
        check_rate(rate, self.motion.duration)
        return self.motion.sample(np.arange(round(self.motion.duration * rate) + 1) / rate)


def design_excitation(
    arm: Arm,
    duration: float = DURATION,
    objective: ObjectiveName = "d",
    starts: int = STARTS,
    harmonics: int = HARMONICS,
    seed: int = 0,
    *,
    noise: ArrayLike = NOISE,
    limits: MotionLimits | None = None,
    clearance: Clearance | None = None,
    columns: TorqueColumns | None = None,
    report: Callable[[float], None] = lambda _: None,
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
    report : function of float
        Called with the share that is done.

    Raises
    ------
    OptionError, ShapeError
        Numbers out of their range, noise of another shape, columns with other friction or a transmission.
    MissingDataError, MissingPackageError
        An arm without masses; numba is not installed.
    ExcitationError
        No start ended clear and inside the limits.

    References
    ----------
    Swevers et al., Optimal robot excitation and identification (1997); Park, Fourier-based optimal excitation
    trajectories for the dynamic identification of robots (2006).
    """
    begin = perf_counter()
    check_choices(objective, starts, seed, duration)
    clear_of = clearance or clearance_of(arm)
    check_room(clear_of)
    design = MotionDesign(
        arm, duration, harmonics, objective, noise_of_joints(noise, arm.n),
        columns or TorqueColumns(arm.require_dynamics()), limits or MotionLimits.of(arm), clear_of,
    )  # fmt: skip
    found: list[SearchedMotion] = []
    for i in range(starts):
        found.append(design.start(np.random.default_rng([seed, i])))
        report((i + 1) / (starts + 1))
    best = design.best_of(found)
    motion, states = design.motion(best.X), design.states(best.X)
    lower, upper = (np.where(np.isinf(x), np.nan, x) for x in (arm.lower, arm.upper))
    aside = np.abs(states[0] - (lower + upper) / 2.0).max(axis=0)
    distances = design.clearance.of(states[0])
    place = int(np.argmin(distances.min(axis=0, initial=np.inf))) if distances.size else 0
    clear = float(distances.min(initial=np.inf))
    return Excitation(
        arm, design.columns, motion, objective,
        motion_score(design.columns, rows_of(motion), design.noise), design.noise,
        aside / ((upper - lower) / 2.0), _share(np.abs(states[1]).max(axis=0), arm.velocity),
        _share(np.abs(design.torques.torque(*states)).max(axis=0), arm.effort), clear + design.clearance.kept,
        design.clearance.names[place] if distances.size else "", tuple(one.summary for one in found),
        perf_counter() - begin, column_words(clear_of), design.check_rate,
    )  # fmt: skip


def rows_of(motion: FourierMotion, rate: float = SCORE_RATE) -> Motion:
    """The motion at `rate` [Hz], each instant of its period once."""
    return motion.sample(np.arange(max(1, round(motion.duration * rate))) / rate)


def check_choices(objective: str, starts: int, seed: int, duration: float = DURATION) -> None:
    """Raise `OptionError` for an objective that does not exist, numbers that are not whole, or out of their range."""
    if objective not in OBJECTIVES:
        raise OptionError("objective", repr(objective), ", ".join(OBJECTIVES))
    if not 0.0 < duration <= LONGEST:
        raise OptionError("duration", duration, f"a time above 0 s, at most {LONGEST:g} s")
    for name, value, least, most in (("starts", starts, 1, MOST_STARTS), ("seed", seed, 0, np.inf)):
        if isinstance(value, bool) or not isinstance(value, int) or not least <= value <= most:
            upto = f" to {most:g}" if np.isfinite(most) else ""
            raise OptionError(name, repr(value), f"a whole number from {least}{upto}")


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
