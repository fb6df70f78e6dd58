"""MuJoCo's reading of a small file: Pinocchio's equation, friction in its motion only, names and limits of the file."""

import numpy as np
import pytest

from lwr_dyn.checks.engines.engine import EXACT, ArmInFile
from lwr_dyn.checks.engines.pinocchio_loader import load as pinocchio_load
from tests.checks.engines.small_files import TWO
from tests.optional import need

need("mujoco")
from lwr_dyn.checks.engines.mujoco_loader import load  # noqa: E402

BARE = TWO[: TWO.index("<visual>")] + "</link></robot>"
"""Without the tool's shapes, which weigh in MuJoCo, and without rotors."""
Q, DQ, DDQ = np.array([0.3, 0.5]), np.array([1.0, -2.0]), np.array([0.4, 0.7])
GRAVITY = (0.5, -1.0, -9.81)
SCOPES = {
    "both": (ArmInFile(("j1", "j2"), "tool", GRAVITY), [0, 1]),
    "the other held": (ArmInFile(("j2",), "tool", GRAVITY, {"j1": 0.3}), [1]),
}


@pytest.mark.parametrize("whole", [True, False])
@pytest.mark.parametrize("name", SCOPES)
def test_it_is_the_equation_of_pinocchio(tmp_path, name, whole):
    path = tmp_path / "two.urdf"
    path.write_text(BARE.replace('friction="0.4"', 'friction="0"'), encoding="utf-8")
    scope, at = SCOPES[name]
    ours, theirs = load(path, scope, {"whole": whole}), pinocchio_load(path, scope, {})
    q, dq, ddq = Q[at], DQ[at], DDQ[at]
    assert ours.mass == theirs.mass == 3.0
    for method, given in (
        ("mass_matrix", (q,)), ("velocity_torque", (q, dq)), ("gravity_torque", (q,)), ("flange", (q,)),
    ):  # fmt: skip
        expected = getattr(theirs, method)(*given)
        np.testing.assert_allclose(getattr(ours, method)(*given), expected, rtol=EXACT, atol=EXACT)
    whole_motion = ours.mass_matrix(q) @ ddq + ours.velocity_torque(q, dq) + ours.gravity_torque(q)
    damping = np.array([0.7, 0.0])[at] * dq
    np.testing.assert_allclose(ours.torque(q, dq, ddq), whole_motion + damping, rtol=EXACT, atol=EXACT)


def test_it_holds_limits_friction_and_the_links_that_are_left(tmp_path):
    path = tmp_path / "two.urdf"
    path.write_text(BARE, encoding="utf-8")
    scope = SCOPES["both"][0]
    held = {name: values.tolist() for name, values in load(path, scope, {}).held().items()}
    assert held == {
        "lower": [-2.0, -np.inf], "upper": [2.0, np.inf], "effort": [50.0, 20.0], "viscous": [0.7, 0.0],
        "coulomb": [0.4, 0.0],
    }  # fmt: skip
    assert load(path, scope, {}).links() == ["world", "upper", "lower"]
    assert load(path, scope, {"whole": True}).links() == ["world", "base", "upper", "lower", "tool"]
