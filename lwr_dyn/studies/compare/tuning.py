"""Gains of one margin for all controllers of a study: the largest omega_n whose loop keeps it along the task.

The margin is the largest |S_ii| over the joints and frequencies at the worst of several plants: the arm as modelled
with a delay of 1 to 4 samples, and with its elastic gears where its file gives them and its rotors carry them. A law
is judged by its linear form at rest at poses of the task, which says nothing of large errors or of torque limits.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from lwr_dyn.control.controller_specs import ControllerSpec
from lwr_dyn.control.controllers import CONTROLLERS
from lwr_dyn.design.gain_search import TunedFrequency, largest_omega_n
from lwr_dyn.design.loop_case import LoopCase
from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.progress import Report
from lwr_dyn.foundation.registry import options_of
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Reference
from lwr_dyn.simulation.elastic.plant import SLOWEST, fastest_on_motors

DELAYS = (1, 2, 3, 4)
"""[samples]"""
POSES = 21
"""Of the task, evenly in time, at which a loop is judged."""


def tuned_frequencies(
    arm: Arm,
    specs: Sequence[ControllerSpec],
    reference: Reference,
    peak: float,
    rate: float = 1000.0,
    report: Report = lambda _: None,
) -> Mapping[str, TunedFrequency]:
    """Controller as typed -> its largest omega_n [1/s] with |S_ii| at most `peak`, None where none keeps it.

    Files, and laws without an option omega_n, are left out.

    Raises
    ------
    OptionError
        A peak that is not above 1, a controller whose text gives omega_n already.
    """
    if not (np.isfinite(peak) and peak > 1.0):
        raise OptionError("tuned", peak, "a peak of |S| above 1, as 1.7")
    poses = poses_of(reference)
    cases = cases_of(arm, rate, poses)
    dynamics = dynamics_of(arm)
    found = {}
    for spec in (spec for spec in specs if has_frequency(spec)):
        if "omega_n" in spec.options:
            raise OptionError(f"controller {spec.text!r}", "omega-n given, which is to be tuned", "without it")
        report(f"tuning {spec.text}")
        found[spec.text] = largest_omega_n(arm, spec.name, cases, q=poses, peak=peak, dynamics=dynamics, **spec.options)
    return found


def has_frequency(spec: ControllerSpec) -> bool:
    """Whether a controller has an option omega_n."""
    return not spec.is_file and "omega_n" in options_of(CONTROLLERS.load(spec.base))


def poses_of(reference: Reference) -> Array:
    """Poses (k, n) of a reference, evenly in time."""
    return np.asarray(reference.sample(np.linspace(0.0, reference.duration, POSES)).q)


def cases_of(arm: Arm, rate: float, poses: Array) -> tuple[LoopCase, ...]:
    """The plants of the margin; elastic gears only where the arm can have them."""
    rigid = tuple(LoopCase(rate=rate, delay=delay) for delay in DELAYS)
    return (*rigid, LoopCase(rate=rate, elasticity="file")) if is_elastic(arm, rate, poses) else rigid


def is_elastic(arm: Arm, rate: float, poses: Array) -> bool:
    """Whether the arm gives the stiffness of its gears, and has rotors that a law on the motors' side can drive."""
    if arm.elasticity is None or not (arm.armature > 0.0).all():
        return False
    B = dynamics_of(arm).mass_matrix(poses)
    return bool((fastest_on_motors(rate, arm.armature, B) >= SLOWEST).all())
