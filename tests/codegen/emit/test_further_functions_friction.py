"""Friction in C: per direction, with Stribeck's curve, at rest, and smooth; an arm without friction has none."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.emit.emission import emitted_arm
from lwr_dyn.codegen.emit.further_functions import TEXT
from lwr_dyn.foundation.errors import MissingDataError
from lwr_dyn.model.friction import Direction, JointFriction, friction_torque, smooth_friction
from tests.codegen.emit.shared_library import SharedLibrary

CLOSE = 1e-14
SPEEDS = np.array([-2.0, -1e-3, 0.0, 1e-6, 0.02, 1.5])


class FrictionOf:
    """An arm with other friction."""

    def __init__(self, arm, models):
        self.arm, self.models = arm, models

    def __getattr__(self, name):
        return getattr(self.arm, name)

    def friction_models(self):
        return self.models


@pytest.mark.parametrize("curve", [None, 0.05])
def test_friction_is_that_of_the_models(curve, tmp_path):
    arm = lwr_dyn.load("wam7")
    models = arm.friction_models()
    if curve is not None:
        first = JointFriction(Direction(4.0, 1.0, 6.0, curve), Direction(3.0, 0.5, 3.5, 2.0 * curve), 0.3)
        models = (first, *models[1:])
    library = SharedLibrary(emitted_arm(FrictionOf(arm, models), list(TEXT)), tmp_path)
    out, width = np.zeros(7), 2e-3
    smooth = smooth_friction(models, width)
    for speed in SPEEDS:
        dq = speed * np.linspace(1.0, 1.3, 7)
        library.call("friction_torque", dq, out, kind=None)
        assert np.abs(out - friction_torque(models, dq)).max() < CLOSE * 10.0
        library.call("smooth_friction_torque", dq, np.array([width]), out, kind=None)
        assert np.abs(out - smooth(dq)).max() < CLOSE * 10.0


def test_an_arm_without_friction_has_none():
    with pytest.raises(MissingDataError, match="friction"):
        emitted_arm(lwr_dyn.load("lwr4plus"), ["friction_torque"])
