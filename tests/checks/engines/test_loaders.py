"""Each engine on a small file: Pinocchio's equation, friction, names, limits and tip of the file."""

import numpy as np
import pytest

from lwr_dyn.checks.engines.engine import EXACT, ArmInFile
from lwr_dyn.checks.engines.loaders import BulletFile, DrakeFile, MujocoFile, YourdfpyFile
from lwr_dyn.checks.engines.pinocchio_loader import PinocchioFile
from tests.checks.engines.small_files import TWO
from tests.optional import need

BARE = TWO[: TWO.index("<visual>")] + "</link></robot>"
"""Without the tool's shapes, which weigh in MuJoCo, and without rotors."""
WEIGHTLESS = """<inertial><mass value="0"/><inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial>
</link></robot>"""
"""Of the tool: PyBullet gives a link without numbers 1 kg."""
Q, DQ, DDQ = np.array([0.3, 0.5]), np.array([1.0, -2.0]), np.array([0.4, 0.7])
GRAVITY = (0.5, -1.0, -9.81)
SCOPES = {
    "both": (ArmInFile(("j1", "j2"), "tool", GRAVITY), [0, 1]),
    "the other held": (ArmInFile(("j2",), "tool", GRAVITY, {"j1": 0.3}), [1]),
}


@pytest.fixture
def written(tmp_path):
    def write(text):
        path = tmp_path / "two.urdf"
        path.write_text(text, encoding="utf-8")
        return path

    return write


EQUATION = {
    "mujoco": (MujocoFile, {"whole": False}, BARE, EXACT, EXACT),
    "mujoco, whole": (MujocoFile, {"whole": True}, BARE, EXACT, EXACT),
    "pydrake": (DrakeFile, {}, BARE, EXACT, EXACT),
    "pybullet": (BulletFile, {"still": True}, BARE.replace("</link></robot>", WEIGHTLESS), 1e-6, 1e-3),
}
"""Engine, options, file, and the tolerances of its parts and of its torque: PyBullet keeps places in single precision
(6e-8), and its torque is that of one step of 1e-5 s."""


@pytest.mark.parametrize("engine", EQUATION)
@pytest.mark.parametrize("name", SCOPES)
def test_an_engine_has_the_equation_of_pinocchio(written, name, engine):
    need(engine.partition(",")[0])
    load, options, text, exact, near = EQUATION[engine]
    path, (scope, at) = written(text.replace('friction="0.4"', 'friction="0"')), SCOPES[name]
    ours, theirs = load(path, scope, options), PinocchioFile(path, scope, {})
    q, dq, ddq = Q[at], DQ[at], DDQ[at]
    assert ours.mass == theirs.mass == 3.0
    for method, given in (
        ("mass_matrix", (q,)), ("velocity_torque", (q, dq)), ("gravity_torque", (q,)), ("flange", (q,)),
    ):  # fmt: skip
        expected = getattr(theirs, method)(*given)
        np.testing.assert_allclose(getattr(ours, method)(*given), expected, rtol=exact, atol=exact)
    whole_motion = ours.mass_matrix(q) @ ddq + ours.velocity_torque(q, dq) + ours.gravity_torque(q)
    damping = np.array([0.7, 0.0])[at] * dq
    np.testing.assert_allclose(ours.torque(q, dq, ddq), whole_motion + damping, rtol=near, atol=near)


def test_drake_and_pybullet_hold_what_the_file_says(written):
    limits = {"lower": [-2.0, -np.inf], "upper": [2.0, np.inf], "velocity": [3.0, 4.0], "viscous": [0.7, 0.0]}
    path, scope = written(TWO), SCOPES["both"][0]
    need("pydrake")
    drake = DrakeFile(path, scope, {})
    assert {name: values.tolist() for name, values in drake.held().items()} == limits | {"effort": [50.0, np.inf]}
    assert drake.links() == ["base", "upper", "lower", "tool"]
    need("pybullet")
    bullet = BulletFile(path, scope, {})
    assert {name: values.tolist() for name, values in bullet.held().items()} == limits | {
        "effort": [50.0, 20.0], "coulomb": [0.4, 0.0],
    }  # fmt: skip
    assert sorted(bullet.links()) == ["base", "lower", "tool", "upper"]


def test_mujoco_holds_limits_friction_and_the_links_that_are_left(written):
    need("mujoco")
    path, scope = written(BARE), SCOPES["both"][0]
    assert {name: values.tolist() for name, values in MujocoFile(path, scope, {}).held().items()} == {
        "lower": [-2.0, -np.inf], "upper": [2.0, np.inf], "effort": [50.0, 20.0], "viscous": [0.7, 0.0],
        "coulomb": [0.4, 0.0],
    }  # fmt: skip
    assert MujocoFile(path, scope, {}).links() == ["world", "upper", "lower"]
    assert MujocoFile(path, scope, {"whole": True}).links() == ["world", "base", "upper", "lower", "tool"]


def test_yourdfpy_has_limits_masses_and_links_of_the_file(written):
    model = YourdfpyFile(written(TWO), SCOPES["both"][0], {})
    assert {name: values.tolist() for name, values in model.held().items()} == {
        "lower": [-2.0, -np.inf], "upper": [2.0, np.inf], "velocity": [3.0, 4.0], "effort": [50.0, 20.0],
        "viscous": [0.7, 0.0], "coulomb": [0.4, 0.0],
    }  # fmt: skip
    assert (model.mass, model.links()) == (3.0, ["base", "upper", "lower", "tool"])
    assert model.flange(np.array([np.pi / 2, 0.0]))[:3, 3] == pytest.approx([0.6, 0.0, 0.3])  # j1 turns about y


def test_yourdfpy_holds_a_joint_beside_the_arm_and_a_fixed_one_is_no_fault(written):
    model = YourdfpyFile(written(TWO), ArmInFile(("j2",), "tool", GRAVITY, {"j1": np.pi / 2, "fixed": 1.0}), {})
    assert model.flange(np.array([np.pi / 2]))[:3, 3] == pytest.approx([0.4, -0.2, 0.3])
