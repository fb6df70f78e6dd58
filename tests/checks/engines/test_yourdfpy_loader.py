"""yourdfpy's reading of a small file: limits, friction, masses and the tip, other joints held."""

import numpy as np
import pytest

from lwr_dyn.checks.engines.engine import ArmInFile
from lwr_dyn.checks.engines.yourdfpy_loader import load
from tests.checks.engines.small_files import TWO


def test_limits_masses_and_links_are_those_of_the_file(tmp_path):
    path = tmp_path / "two.urdf"
    path.write_text(TWO, encoding="utf-8")
    model = load(path, ArmInFile(("j1", "j2"), "tool", (0.0, 0.0, -9.81)), {})
    assert {name: values.tolist() for name, values in model.held().items()} == {
        "lower": [-2.0, -np.inf], "upper": [2.0, np.inf], "velocity": [3.0, 4.0], "effort": [50.0, 20.0],
        "viscous": [0.7, 0.0], "coulomb": [0.4, 0.0],
    }  # fmt: skip
    assert (model.mass, model.links()) == (3.0, ["base", "upper", "lower", "tool"])
    assert model.flange(np.array([np.pi / 2, 0.0]))[:3, 3] == pytest.approx([0.6, 0.0, 0.3])  # j1 turns about y


def test_a_joint_beside_the_arm_is_held_and_a_fixed_one_is_no_fault(tmp_path):
    path = tmp_path / "two.urdf"
    path.write_text(TWO, encoding="utf-8")
    model = load(path, ArmInFile(("j2",), "tool", (0.0, 0.0, -9.81), {"j1": np.pi / 2, "fixed": 1.0}), {})
    assert model.flange(np.array([np.pi / 2]))[:3, 3] == pytest.approx([0.4, -0.2, 0.3])
