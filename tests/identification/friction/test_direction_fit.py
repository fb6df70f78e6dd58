"""One direction of a friction map: Stribeck, outliers."""

import numpy as np
import pytest

from lwr_dyn.identification.friction.identify_friction import FitOptions, identify_friction
from lwr_dyn.identification.logs.simulated_logs import LogSensors
from lwr_dyn.model.friction import Direction, JointFriction
from tests.identification.simulated import ideal_cruise

IDEAL = 1e-6
"""Relative error allowed with logs without noise; rounding gives 1e-11."""


def test_a_stribeck_dip_comes_back():
    truth = JointFriction(Direction(4.0, 1.2, 6.0, 0.05), Direction(3.0, -0.5, 3.9, 0.08))
    speeds = [s * v for s in (1, -1) for v in (0.01, 0.02, 0.03, 0.05, 0.07, 0.1, 0.15, 0.2, 0.3)]
    found = identify_friction([ideal_cruise([truth], [v]) for v in speeds], options=FitOptions(model="stribeck"))
    assert not found.faults
    for fit, way in zip(found.fits, (truth.positive, truth.negative), strict=True):
        assert fit.estimate.values == pytest.approx(
            [way.coulomb, way.viscous, way.static, way.stribeck_velocity], abs=IDEAL
        )


def test_wild_cruises_pull_squares_but_not_the_robust_fit():
    truth = JointFriction(Direction(4.0, 1.0), Direction(3.0, 2.0))
    logs = [ideal_cruise([truth], [v]) for v in np.linspace(0.05, 0.4, 12)]
    wild = ideal_cruise([JointFriction(Direction(9.0, 1.0), Direction(3.0, 2.0))], [0.38])
    noisy = [LogSensors(0.02).through(log, i) for i, log in enumerate([*logs, wild])]
    squares, robust = (
        identify_friction(noisy, options=FitOptions(robust=r)).fit(1, 1).estimate.values for r in (False, True)
    )
    assert abs(squares - [4.0, 1.0]).max() > 1.0
    assert abs(robust - [4.0, 1.0]).max() < 0.05


def test_a_wild_cruise_does_not_pull_a_robust_stribeck_fit():
    truth, speeds = JointFriction(Direction(4.0, 1.2, 6.0, 0.05), Direction(3.0, 2.0)), np.geomspace(0.01, 0.4, 14)
    logs = [ideal_cruise([truth], [v]) for v in speeds]
    wild = ideal_cruise([JointFriction(Direction(9.0, 1.2), Direction(3.0, 2.0))], [0.38])
    noisy = [LogSensors(0.002).through(log, i) for i, log in enumerate([*logs, wild])]
    squares, robust = (
        identify_friction(noisy, options=FitOptions(model="stribeck", robust=r)).fit(1, 1).estimate
        for r in (False, True)
    )
    wanted = [4.0, 1.2, 6.0, 0.05]
    assert abs(squares.values - wanted).max() > 0.5
    assert (abs(robust.values - wanted) < 3.0 * robust.standard_errors).all()
    assert (robust.standard_errors < [0.1, 0.2, 0.2, 0.01]).all()
