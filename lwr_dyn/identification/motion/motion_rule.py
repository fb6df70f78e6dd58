"""How parameters are taken from logs of any motion."""

from dataclasses import dataclass

from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.identification.regression.joint_columns import FrictionForm
from lwr_dyn.identification.regression.samples import DEFAULT_SAMPLES, SampleRule

LARGEST_DEVIATION = 10.0  # beyond, the table says nothing and leaves no bodies


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
    folds : int
        Parts into which the motions are dealt; each is kept from a fit in turn.
    deviation : float, optional
        Relative deviation of the arm from its table that is expected, such as 0.2; that of most evidence if not given.
    known : tuple of str
        What is known for certain of the bodies, as `total mass = 15.8` or `m_7 = 0.24` (`constraints_of`).

    Raises
    ------
    OptionError
        A deviation that is not above 0 or beyond `LARGEST_DEVIATION`; fewer than two folds.
    """

    samples: SampleRule = DEFAULT_SAMPLES
    friction: FrictionForm = "directions"
    stribeck: bool = False
    folds: int = 5
    deviation: float | None = None
    known: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if self.folds < 2:
            raise OptionError("folds", self.folds, "a number of at least 2")
        if self.deviation is not None and not (0.0 < self.deviation <= LARGEST_DEVIATION):
            allowed = f"a share above 0 and up to {LARGEST_DEVIATION:g}, such as 0.2 for 20 %"
            raise OptionError("deviation", self.deviation, allowed)

    @property
    def weight(self) -> float | None:
        """Of the table in the consistent fit."""
        return None if self.deviation is None else self.deviation**-2


DEFAULT_MOTION = MotionRule()
