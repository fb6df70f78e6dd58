"""What a loop is judged with: how it is sampled, and whether its joints are elastic."""

from dataclasses import dataclass

from lwr_dyn.control.linear_feedback import Linearised
from lwr_dyn.control.protocol import Controller
from lwr_dyn.control.velocity import FilteredDifference
from lwr_dyn.design.elastic_loop import ElasticArm, at_rest
from lwr_dyn.design.law_differences import law_at_rest
from lwr_dyn.design.resting_plant import RestingPlant, rigid_plant
from lwr_dyn.design.sampled_loop import RestingLoop, Sampling
from lwr_dyn.dynamics.protocol import Dynamics
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.elasticity import JointElasticity, chosen_elasticity
from lwr_dyn.simulation.setup import ENCODERS


@dataclass(frozen=True, slots=True)
class LoopCase:
    """A plant and a sampling: rigid joints without delay if nothing is given.

    Parameters
    ----------
    rate : float
        Samples a second [Hz].
    delay : int
        From a command to its torque [samples].
    cutoff_hz : float, optional
        Of the velocity filter of an encoder [Hz]; true speeds if not given.
    elasticity : "file", float or JointElasticity, optional
        As of `simulate`: stiffness of the file, or the largest stiffness [N m/rad]; rigid joints if not given.
    encoders : {"motor", "link"}
        The side that ordinary laws read on elastic joints.

    Raises
    ------
    OptionError
        A rate, a delay or a cut-off that cannot be, another side.
    """

    rate: float = 1000.0
    delay: int = 0
    cutoff_hz: float | None = None
    elasticity: JointElasticity | str | float | None = None
    encoders: str = "motor"

    def __post_init__(self) -> None:
        Sampling(self.rate, self.delay)
        if self.cutoff_hz is not None:
            FilteredDifference(self.cutoff_hz, self.rate)
        if self.encoders not in ENCODERS:
            raise OptionError("encoders", repr(self.encoders), " or ".join(ENCODERS))

    @property
    def sampling(self) -> Sampling:
        """How the controller is sampled."""
        return Sampling(self.rate, self.delay, self.cutoff_hz)

    @property
    def words(self) -> str:
        """The case in words.

        >>> LoopCase(delay=1).words, LoopCase(elasticity=1e4, encoders="link").words
        ('rigid, 1000 Hz, delay of 1 sample', 'elastic (10000 N m/rad, link encoders), 1000 Hz')
        """
        stiffness = f"{self.elasticity:g} N m/rad, " if isinstance(self.elasticity, float | int) else ""
        parts = ["rigid" if self.elasticity is None else f"elastic ({stiffness}{self.encoders} encoders)"]
        parts += [f"{self.rate:g} Hz"]
        parts += [f"delay of {self.delay} sample{'s' if self.delay > 1 else ''}"] if self.delay else []
        parts += [f"speeds filtered at {self.cutoff_hz:g} Hz"] if self.cutoff_hz is not None else []
        return ", ".join(parts)

    def plant(self, arm: Arm, dynamics: Dynamics, q: Array, motor: bool = False) -> RestingPlant:
        """The arm near rest at the poses q (k, n); `motor` for a law that reads the motor side whatever is given.

        Raises
        ------
        OptionError
            A singular mass matrix, a stiffness that cannot be, no rotor at an elastic joint.
        MissingDataError
            "file" for an arm whose file gives no stiffness.
        """
        elastic = self._elastic(arm, dynamics, motor)
        return rigid_plant(dynamics, q) if elastic is None else elastic.plant(at_rest(q))

    def seen(self, arm: Arm, dynamics: Dynamics, q: Array, motor: bool = False) -> Array:
        """What the law reads (k, n) where the links rest at q: motors turn ahead by g / K. Raises as `plant`."""
        elastic = self._elastic(arm, dynamics, motor)
        on_motor = motor or self.encoders == "motor"
        return q if elastic is None or not on_motor else elastic.spring_side(at_rest(q))

    def loop(self, arm: Arm, dynamics: Dynamics, controller: Controller, q: Array) -> RestingLoop:
        """The loop at the poses q (k, n), the law linearised at what it reads; raises as `plant`, `law_at_rest`."""
        motor = reads_motor(controller, q)
        seen = self.seen(arm, dynamics, q, motor)
        law = law_at_rest(controller, seen).feedback
        return RestingLoop.of_plant(self.plant(arm, dynamics, q, motor), law, seen)

    def _elastic(self, arm: Arm, dynamics: Dynamics, motor: bool) -> ElasticArm | None:
        elasticity = chosen_elasticity(arm, self.elasticity)
        if elasticity is None:
            return None
        return ElasticArm(dynamics, elasticity, arm.armature, "motor" if motor else self.encoders)


def reads_motor(controller: Controller, q: Array) -> bool:
    """Whether a law says that it reads the motor side whatever the encoders are."""
    return isinstance(controller, Linearised) and controller.linear_feedback(q[:1]).motor
