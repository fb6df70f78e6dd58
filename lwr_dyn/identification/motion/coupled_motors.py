"""Motors that turn several joints, in logs of the joints: whether rotors and friction are those of the motors.

    tau = tau_bodies + T^T (J T ddq + f(T dq))

T is the arm's motor map with speeds seen at the joints (`Transmission.at_joints`): J and f of a motor with a joint of
its own are that joint's, and J of a coupled one stands between its joints too. A source may have measured friction
joint by joint, and gears behind the coupling rub as joints do. So the log decides: both forms have as many parameters,
and the one that leaves less on the joints that share motors is taken.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from lwr_dyn.foundation.errors import LogError, OptionError
from lwr_dyn.identification.logs.joint_log import JointLog
from lwr_dyn.identification.motion.motion_result import MotionRule
from lwr_dyn.identification.regression.information import information_of
from lwr_dyn.identification.regression.samples import SampleRule, samples_of
from lwr_dyn.model.arm import Arm

GAIN = 0.02
"""Log likelihood of an equation of the joints that share motors, a fiftieth of the noise, by which motors must be the
better: a model has places for rotors and friction of joints."""


def with_motors(rule: MotionRule, logs: Sequence[JointLog], arm: Arm) -> MotionRule:
    """The rule with columns of the motors where it asks for them, or where it leaves that open and the logs say so.

    Raises
    ------
    OptionError
        Motors are asked for and the arm has none that turn several joints, or torques are from behind the gears; or
        they are asked for with what those with a joint each can have (`MotionRule`).
    """
    if rule.coupled is False or rule.samples.transmission is not None:
        return rule
    motors = None if rule.samples.link_side else _at_motors(rule.samples, arm)
    if rule.coupled:
        if motors is None:
            found = f"asked for of {arm.name}, whose torques have none"
            raise OptionError("coupled motors", found, "a robot whose motor map has some, and torques of its motors")
        return replace(rule, samples=motors)
    if motors is None or rule.gains is not None or rule.load_friction:
        return rule
    return replace(rule, samples=motors) if _gain(logs, arm, rule, motors) > GAIN else rule


def _at_motors(rule: SampleRule, arm: Arm) -> SampleRule | None:
    """Instants for columns of the motors, seen at the joints; None where each has a joint of its own.

    A motor is slow where it is slower than where its joints have the rule's speed.
    """
    if arm.transmission is None or not arm.transmission.coupled.any():
        return None
    motors = arm.transmission.at_joints()
    if not motors.seen_at_joints:  # no joint has the number of some motor
        return None
    return replace(rule, slowest=rule.slowest * np.linalg.norm(motors.matrix, axis=1), transmission=motors)


def _gain(logs: Sequence[JointLog], arm: Arm, rule: MotionRule, motors: SampleRule) -> float:
    """Log likelihood of an equation of the joints that share motors: of columns of the motors, less that of joints'.

    By the equations that count for both; 0 where they cannot be judged.
    """
    both = rule.samples, motors
    try:
        samples, others = (samples_of(logs, one) for one in both)
        samples = replace(samples, used=samples.used & others.used)
        of_joints, of_motors = (information_of(samples, replace(rule, samples=one).columns(arm)) for one in both)
    except LogError:
        return 0.0
    assert motors.transmission is not None
    shared = motors.transmission.coupled & (of_joints.equations > 0)
    count = of_joints.equations[shared]
    if not count.sum() or min(of_joints.dof, of_motors.dof) <= 0:
        return 0.0
    return float(count @ np.log(of_joints.noise[shared] / of_motors.noise[shared]) / count.sum())
