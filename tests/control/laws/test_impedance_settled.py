"""Stiffness of the settled tip: as asked in regular and inner singular poses, not outward of a stretched elbow.

A share of the poses; `scripts/soak.py impedance` tries all twenty.
"""

import numpy as np
import pytest

from lwr_dyn.model.friction import symmetric
from tests.control.laws.settled import (
    FORCE,
    SETTLED_S,
    SINGULAR,
    STRETCHED,
    deflection,
    direction,
    elbow_stiffness,
    friction_band,
    pushed,
    regular_poses,
    stiffness_error,
)
from tests.control.laws.written_out import ARM, REGULAR, tip_offset

ASKED = 1e-4
"""Relative, of the vector: what slow modes leave after `SETTLED_S`."""


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2))
def test_regular_poses_have_the_stiffness_that_was_asked(seed):
    assert stiffness_error(regular_poses(3)[seed], seed, SETTLED_S["regular"]) < ASKED


@pytest.mark.slow
def test_an_inner_singularity_keeps_the_stiffness():
    assert stiffness_error(SINGULAR[2], 2, SETTLED_S["singular"]) < ASKED


@pytest.mark.slow
def test_outward_of_a_stretched_elbow_the_workspace_ends():
    """The arm cannot give way further than its length: k/K = 2.46 at q4 = 0.2."""
    found = elbow_stiffness(STRETCHED[0.2], ("outward", "inward"), 3.0)
    assert found["outward"] > 2.0
    assert abs(found["inward"] - 1.0) < ASKED


@pytest.mark.slow
@pytest.mark.parametrize("level", [0.1, 0.5])
def test_dry_friction_holds_the_tip_off_within_its_band(level):
    force = FORCE * direction(1)
    run = pushed(REGULAR, force, 1.5, friction=[symmetric(level, 0.0)] * 7)
    assert np.abs(run.dq[-1]).max() < 1e-6
    K = np.array([2000.0] * 3 + [200.0] * 3)
    missing = K * tip_offset(ARM, run.q_ref[-1], run.q[-1]) + np.concatenate([force, np.zeros(3)])
    band = friction_band(run.q[-1], level)
    assert (np.abs(missing) <= band * (1.0 + 1e-6)).all()
    assert np.linalg.norm(missing[:3]) > 0.02 * np.linalg.norm(band[:3])  # the band is not empty


def test_the_tip_gives_way_along_the_force():
    away = deflection(pushed(REGULAR, FORCE * direction(2), 3.0, stiffness=1000.0))
    np.testing.assert_allclose(away, 0.02 * direction(2), atol=1e-6)
