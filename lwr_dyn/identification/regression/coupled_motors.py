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
from lwr_dyn.identification.regression.information import information_of
from lwr_dyn.identification.regression.samples import SampleRule, samples_of
from lwr_dyn.identification.regression.torque_columns import FrictionForm, TorqueColumns
from lwr_dyn.model.arm import Arm

GAIN = 0.02
"""Log likelihood of an equation of the joints that share motors, a fiftieth of the noise, by which motors must be the
better: a model has places for rotors and friction of joints."""


def has_coupled_motors(arm: Arm, rule: SampleRule) -> bool:
    """Whether motors of the arm turn several joints, in logs of joints whose torques have the motors' in them.

    Not where some motor turns no joint of its own number: its speed is not seen at any.
    """
    if arm.transmission is None or rule.link_side or rule.transmission is not None:
        return False
    return bool(arm.transmission.coupled.any()) and arm.transmission.at_joints().seen_at_joints


def at_motors(rule: SampleRule, arm: Arm) -> SampleRule:
    """Instants for columns of the motors, seen at the joints.

    A motor is slow where it is slower than where its joints have the rule's speed.

    Raises
    ------
    OptionError
        An arm or a rule without them (`has_coupled_motors`).
    """
    if arm.transmission is None or not has_coupled_motors(arm, rule):
        found = f"asked for of {arm.name}, whose torques have none"
        raise OptionError("coupled motors", found, "a robot whose motor map has some, and torques of its motors")
    motors = arm.transmission.at_joints()
    return replace(rule, slowest=rule.slowest * np.linalg.norm(motors.matrix, axis=1), transmission=motors)


def motors_or_joints(rule: SampleRule, logs: Sequence[JointLog], arm: Arm, friction: FrictionForm) -> SampleRule:
    """The rule, or that of columns of the motors where the logs ask for them."""
    if not has_coupled_motors(arm, rule):
        return rule
    motors = at_motors(rule, arm)
    return motors if _gain(logs, arm, (rule, motors), friction) > GAIN else rule


def _gain(logs: Sequence[JointLog], arm: Arm, rules: tuple[SampleRule, SampleRule], friction: FrictionForm) -> float:
    """Log likelihood of an equation of the joints that share motors: by the second of the rules less by the first.

    Of the equations that count for both; 0 where they cannot be judged.
    """
    try:
        samples, others = (samples_of(logs, one) for one in rules)
        samples = replace(samples, used=samples.used & others.used)
        of_joints, of_motors = (
            information_of(samples, TorqueColumns(arm.chain, friction, transmission=one.transmission)) for one in rules
        )
    except LogError:
        return 0.0
    motors = rules[1].transmission
    assert motors is not None
    shared = motors.coupled & (of_joints.equations > 0)
    count = of_joints.equations[shared]
    if not count.sum() or min(of_joints.dof, of_motors.dof) <= 0:
        return 0.0
    return float(count @ np.log(of_joints.noise[shared] / of_motors.noise[shared]) / count.sum())
