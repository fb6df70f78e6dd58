"""The commented study that `lwr-dyn new study` writes: for the LWR 4+, or fitted to an arm.

For an arm: a move inside its limits (`chosen_move`), laws whose sampled loop is stable at rest along it at the delays
that the study varies, a load of a tenth of what moves where the motors hold it, and friction where its steps are short
enough for RK4.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from importlib.resources import files
from textwrap import wrap

import numpy as np

from lwr_dyn.control.controllers import controller_spec
from lwr_dyn.control.laws.robust import held_load
from lwr_dyn.design.defaults import law_stability
from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.dynamics.protocol import Dynamics
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import MissingDataError, OptionError
from lwr_dyn.model.arm import Arm, arm_with_payload
from lwr_dyn.model.chain import JointKind
from lwr_dyn.simulation.arm_friction import ArmFriction, braking_rate
from lwr_dyn.simulation.setup import STABLE
from lwr_dyn.simulation.substeps import MOST, SPARE, power_of_two
from lwr_dyn.studies.sweep.vocabulary import OPTION, PATHS
from lwr_dyn.trajectory.references.chosen_move import chosen_move
from lwr_dyn.trajectory.references.joint_moves import JointReference

RATE, DELAYS = 1000.0, (0, 1, 2)
"""[Hz] and [samples] of the loops of a study."""

LAWS, MOST_LAWS = ("inverse-dynamics", "pd-gravity", "pid", "robust:omega-n=50"), 3
"""Laws that are tried for an arm, and how many its study takes."""

FRICTION, WIDTH = 0.02, 0.02
"""Share of the torque limit, and the speed [rad/s] over which the smooth law turns round."""

LOAD, LEAST_LOAD = 0.1, 0.001
"""Largest load as a share of the mass that moves; what is left of it where the torque limits hold less."""
MASSES = 0.1
"""How far the template lets masses vary, as a share."""

COLUMN = 28
"""Where a comment begins."""

FRICTION_TABLE = f"""[[parameter]]
path = "friction.coulomb"   # share of the torque limit, of the plant alone
low = 0
high = {FRICTION:g}
kind = "assumed"
"""

OF_LWR = {
    "robot": 'robot = "lwr4plus"          # a robot, or a .toml or .urdf beside this file\n'
    'reading = "physical"        # how its tables are read',
    "controllers": '["inverse-dynamics", "adaptive", "robust:omega-n=50"]',
    "from": "[0, 30, 0, -60, 0, 30, 0]",
    "to": "[30, 45, 0, -75, 0, 45, 0]",
    "duration": "1.5             ",
    "substeps": "substeps = 1               ",
    "saturated": "saturated_s = 0             # s beyond a torque limit",
    "payload": "5",
    "friction": FRICTION_TABLE.rstrip(),
}
"""What stands in the template's places for the LWR 4+."""


def study_template(file: str, name: str, robot: str | None = None, arm: Arm | None = None) -> str:
    """The text of a commented study; it runs as it stands.

    Parameters
    ----------
    file, name
        Of the study.
    robot, arm
        How the study names its robot, and that arm; the LWR 4+ if not given.

    Raises
    ------
    OptionError, MissingDataError
        No task for the arm (`chosen_move`), no law whose loop is stable, an arm without masses.

    >>> 'path = "payload.mass"' in study_template("x.toml", "x")
    True
    """
    text = (files("lwr_dyn.studies.sweep") / "new_study.toml").read_text(encoding="utf-8")
    paths = ", ".join(path for path in PATHS if OPTION not in path)
    listed = "\n#   ".join(wrap(paths, 100))
    of_arm = OF_LWR if robot is None or arm is None else _of_arm(robot, arm)
    shared = {"lightest": f"{1.0 - MASSES:g}", "heaviest": f"{1.0 + MASSES:g}", "width": f"{WIDTH:g}".ljust(10)}
    for place, words in {**of_arm, **shared, "file": file, "name": name, "paths": f"\n#   {listed}"}.items():
        text = text.replace(f"@@{place}@@", words)
    return text


def _of_arm(robot: str, arm: Arm) -> Mapping[str, str]:
    """What stands in the template's places for an arm."""
    arm.require_dynamics()
    dynamics, move = dynamics_of(arm), chosen_move(arm)
    friction = _friction(arm, dynamics, move)
    reading = "" if robot.endswith((".urdf", ".xacro")) else f"\nreading = {_quoted(arm.reading)}"
    known = np.isfinite(arm.effort).all()
    if (tip := arm.loaded_with.get("tip")) is not None:
        reading += f"\n{_aligned(f'tip = {_quoted(tip)}')}# last link of the chain"
    return {
        "robot": f"{_aligned(f'robot = {_quoted(robot)}')}# a robot, or a .toml or .urdf beside this file{reading}",
        "controllers": f"[{', '.join(map(_quoted, _stable_laws(arm, dynamics, move)))}]",
        "from": _degrees(arm, move.waypoints[0]),
        "to": _degrees(arm, move.waypoints[1]),
        "duration": f"{move.duration:g}".ljust(16),
        "substeps": _steps_lines(friction),
        "saturated": OF_LWR["saturated"] if known else "# no saturated_s: torque limits are unknown",
        "payload": f"{_load(arm, dynamics, move):.2g}",
        "friction": FRICTION_TABLE.rstrip() if friction.varied else f"# no friction.coulomb: {friction.why}",
    }


@dataclass(frozen=True, slots=True)
class _StudyFriction:
    """RK4 steps a sample; whether the loops have friction at all, and whether the study varies it, or why not."""

    substeps: int
    law: bool
    varied: bool
    why: str = ""


def _friction(arm: Arm, dynamics: Dynamics, move: JointReference) -> _StudyFriction:
    poses = move.sample(np.linspace(0.0, move.duration, 21)).q
    levels = ArmFriction.of(arm.friction_models())
    own = _steps(dynamics, poses, levels.viscous.max(axis=0) + levels.coulomb.max(axis=0) / WIDTH)
    law = not arm.has_friction or own <= MOST
    if not np.isfinite(arm.effort).all():
        return _StudyFriction(own if law else 1, law, False, "torque limits are unknown, of which it is a share")
    varied = _steps(dynamics, poses, FRICTION * arm.effort / WIDTH)
    if max(varied, own) > MOST:
        what = f"{100 * FRICTION:g} % of the torque limits" if varied > MOST else "the arm's own friction"
        why = f"{what} would need {max(varied, own)} RK4 steps a sample, without rotor inertia"
        return _StudyFriction(own if law else 1, law, False, why)
    return _StudyFriction(max(varied, own), True, True)


def _steps(dynamics: Dynamics, poses: Array, slope: Array) -> int:
    """RK4 steps a sample that friction with these slopes (n,) [N m s/rad] needs, a power of two."""
    rates = braking_rate(dynamics.mass_matrix(poses), np.maximum(slope, 0.0))
    return power_of_two(SPARE * float(rates.max()) / RATE / STABLE)


def _stable_laws(arm: Arm, dynamics: Dynamics, move: JointReference) -> list[str]:
    """Up to three laws that are stable along the move with each delay."""
    found = []
    for text in LAWS:
        try:
            controller = controller_spec(text).make(arm, dynamics)
        except MissingDataError:
            continue
        judged = [law_stability(arm, dynamics, controller, move, RATE, delay) for delay in DELAYS]
        if all(one is not None and one.holds for one in judged):
            found.append(text)
    if not found:
        tried = f"none of {', '.join(LAWS)} is stable at {RATE:g} Hz with a delay of up to {DELAYS[-1]} samples"
        raise OptionError(f"study of {arm.name}, controllers", tried, "a study of your own")
    return found[:MOST_LAWS]


def _load(arm: Arm, dynamics: Dynamics, move: JointReference) -> float:
    """[kg] What the torque limits hold along the move beside the heaviest arm and friction of the study."""
    motion = move.sample(np.linspace(0.0, move.duration, 21))
    own = dynamics.inverse_dynamics(motion.q, motion.dq, motion.ddq)
    loaded = dynamics_of(arm_with_payload(arm, 1.0)).inverse_dynamics(motion.q, motion.dq, motion.ddq)
    held = held_load((1.0 - FRICTION) * arm.effort, (1.0 + MASSES) * own, loaded - own)
    mass = sum(body.mass for body in arm.chain.bodies or ())
    return max(min(LOAD * mass, held), LEAST_LOAD * mass)


def _steps_lines(friction: _StudyFriction) -> str:
    none = (
        "" if friction.law else _aligned('friction = "none"') + "# that of the arm is too stiff for RK4 at this rate\n"
    )
    return f"{none}{f'substeps = {friction.substeps}'.ljust(COLUMN - 1)}"


def _degrees(arm: Arm, q: Array) -> str:
    turning = [link.kind is JointKind.REVOLUTE for link in arm.chain.links]
    return f"[{', '.join(f'{np.degrees(x):.2f}' if t else f'{x:.4f}' for x, t in zip(q, turning, strict=True))}]"


def _quoted(text: str) -> str:
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'


def _aligned(text: str) -> str:
    return text.ljust(COLUMN) if len(text) < COLUMN else f"{text}  "
