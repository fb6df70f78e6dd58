"""A study for an arm: read as it stands, inside the arm's limits, with laws that hold at its delays."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import lwr_dyn
from lwr_dyn.design.defaults import law_stability
from lwr_dyn.foundation.errors import MissingDataError, OptionError
from lwr_dyn.model.arm import JointLimits, arm_with_payload
from lwr_dyn.model.friction import symmetric
from lwr_dyn.studies.sweep import study_template as template
from lwr_dyn.studies.sweep.read_study import study_of_text
from lwr_dyn.studies.sweep.study_template import DELAYS, study_template
from lwr_dyn.studies.sweep.sweep_study import references_of_study
from lwr_dyn.trajectory.references.chosen_move import chosen_move

ROBOTS = Path(pin.__file__).parents[4] / "share/example-robot-data/robots"
URDF = ROBOTS / "ur_description/urdf/ur5_robot.urdf"
XARM = ROBOTS / "xarm_description/urdf/xarm7.urdf"

OF_THE_LWR = """robot = "lwr4plus"          # a robot, or a .toml or .urdf beside this file
reading = "physical"        # how its tables are read
controllers = ["inverse-dynamics", "adaptive", "robust:omega-n=50"]
                            # as `lwr-dyn compare --controllers` takes them; "mine.py" beside this file (slower)
"""


def read(robot, arm):
    return study_of_text(study_template("x.toml", "x", robot, arm), Path("x.toml"))


@pytest.mark.parametrize(
    "robot", [str(URDF), *(pytest.param(robot, marks=pytest.mark.slow) for robot in ("kr30ha", "wam7"))]
)
def test_it_is_read_as_it_stands_and_its_task_and_laws_fit_the_arm(robot):
    arm = lwr_dyn.load(robot)
    study = read(robot, arm)
    (move,) = references_of_study(study)
    q = move.sample(np.linspace(0.0, move.duration, 50)).q
    assert ((q > arm.lower) & (q < arm.upper)).all()
    dynamics = lwr_dyn.dynamics_of(arm)
    assert 1 <= len(study.controllers) <= 3
    for text in study.controllers:
        law = lwr_dyn.controller(text.partition(":")[0], arm)
        assert all(law_stability(arm, dynamics, law, move, 1000.0, delay).holds for delay in DELAYS)
    (load,) = (one for one in study.parameters if one.path == "payload.mass")
    mass = sum(body.mass for body in arm.chain.bodies)
    assert 0.09 * mass < load.high < 0.11 * mass


def test_the_load_is_one_that_the_torque_limits_hold_along_the_task():
    """With motors that just hold the arm, at the largest masses and friction that the study has."""
    arm = lwr_dyn.load(URDF)
    effort = 0.53 * np.abs(_torques(arm, chosen_move(arm))).max()
    weak = replace(arm, limits=tuple(replace(x, effort=effort) for x in arm.limits))
    study = read(str(URDF), weak)
    varied = {one.path: one for one in study.parameters}
    load, heaviest, dry = varied["payload.mass"], varied["arm.mass"].high, varied["friction.coulomb"].high
    (move,) = references_of_study(study)
    own = _torques(weak, move)
    of_load = _torques(arm_with_payload(weak, load.high), move) - own
    used = [np.abs(heaviest * own + share * of_load).max() / effort for share in (0.9, 1.1)]
    assert load.high < 0.09 * sum(body.mass for body in arm.chain.bodies)
    assert used[0] < 1.0 - dry < used[1]


@pytest.mark.parametrize(("effort", "own"), [(150.0, 0.0), (1e3, 0.0), (1e4, 0.0), (1e3, 300.0)])
def test_the_steps_of_friction_are_those_that_its_fastest_rate_needs(effort, own):
    """A smooth law that turns over 0.02 rad/s brakes with 0.02 of the limit over that speed, 1.5 times as fast at most
    as RK4 bears at 1000 Hz; 64 steps are the most."""
    arm = lwr_dyn.load(URDF)
    friction = (symmetric(own, 0.0),) * 6 if own else arm.friction
    arm = replace(arm, limits=tuple(replace(x, effort=effort) for x in arm.limits), friction=friction)
    move, dynamics = chosen_move(arm), lwr_dyn.dynamics_of(arm)
    B = dynamics.mass_matrix(move.sample(np.linspace(0.0, move.duration, 21)).q)

    def steps(coulomb):
        rates = np.linalg.eigvals(np.linalg.inv(B) * (coulomb / 0.02)).real
        return int(2 ** np.ceil(np.log2(max(1.5 * rates.max() / 1000.0 / 2.7, 1.0))))

    need, given = steps(0.02 * effort), steps(own)
    what = "2 % of the torque limits" if need > 64 else "the arm's own friction"
    why = f"{what} would need {max(need, given)} RK4 steps a sample, without rotor inertia"
    found = template._friction(arm, dynamics, move)
    if max(need, given) <= 64:
        assert found == template._StudyFriction(max(need, given), True, True)
        assert template._steps_lines(found) == f"substeps = {max(need, given):<16d}"
    else:
        assert found == template._StudyFriction(1 if given > 64 else given, given <= 64, False, why)
        assert template._steps_lines(found).startswith('friction = "none"') == (given > 64)


def test_the_template_says_how_the_arm_moves_and_what_is_asked():
    arm = lwr_dyn.load(URDF)
    lines = study_template("x.toml", "x", str(URDF), arm).splitlines()
    move = chosen_move(arm)
    ends = [f"[{', '.join(f'{x:.2f}' for x in np.degrees(q))}]" for q in move.waypoints]
    assert {f"from-deg = {ends[0]}", f"to-deg = {ends[1]}", "duration = 2                # s"} <= set(lines)
    assert 'controllers = ["inverse-dynamics", "robust:omega-n=50"]' in lines
    assert "saturated_s = 0             # s beyond a torque limit" in lines
    assert "#     lwr-dyn sweep x.toml --out x" in lines
    assert not [line for line in lines if "@@" in line or line.startswith("reading")]
    study = read(str(URDF), arm)
    assert study.loop["friction_width"] == 0.02
    assert [(one.low, one.high) for one in study.parameters if one.path in ("arm.mass", "friction.coulomb")] == [
        (0.9, 1.1), (0.0, 0.02),
    ]  # fmt: skip


def _torques(arm, move):
    motion = move.sample(np.linspace(0.0, move.duration, 21))
    return lwr_dyn.dynamics_of(arm).inverse_dynamics(motion.q, motion.dq, motion.ddq)


@pytest.mark.slow
def test_what_an_arm_does_not_give_is_left_out_and_said():
    arm = lwr_dyn.load("kr30ha")
    text = study_template("x.toml", "x", "kr30ha", arm)
    assert "# no saturated_s: torque limits are unknown" in text
    assert "# no friction.coulomb: torque limits are unknown, of which it is a share" in text
    assert "friction.coulomb" not in [one.path for one in read("kr30ha", arm).parameters]
    light = study_template("x.toml", "x", str(XARM), lwr_dyn.load(XARM))
    assert "# no friction.coulomb: 2 % of the torque limits would need" in light
    assert "without rotor inertia" in light


def test_without_a_robot_it_is_that_of_the_paper_s_arm():
    text = study_template("first.toml", "first")
    assert OF_THE_LWR in text
    assert "@@" not in text


def test_an_arm_without_masses_or_that_cannot_move_is_refused():
    arm = lwr_dyn.load("wam7")
    bare = replace(arm, chain=replace(arm.chain, links=tuple(replace(one, body=None) for one in arm.chain.links)))
    with pytest.raises(MissingDataError, match="masses"):
        study_template("x.toml", "x", "wam7", bare)
    stuck = replace(arm, limits=(JointLimits(lower=0.0, upper=0.0), *arm.limits[1:]))
    with pytest.raises(OptionError, match="leave no room"):
        study_template("x.toml", "x", "wam7", stuck)
