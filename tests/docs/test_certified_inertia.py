"""The page of certified inertias has every joint of every robot and reading, and a seeded share is proven again."""

import sys
from pathlib import Path

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.control.inertia.certificate import inertia_certificate
from lwr_dyn.control.inertia.worst_case import worst_case_inertias

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
import certified_inertia  # noqa: E402

SHARE, SEED, QUICK = 8, 27, 0.5
"""Rows that are proven again, of those that took fewer seconds than `QUICK`; all: scripts/certified_inertia.py."""
BOXES = 0.05
"""Relative: boxes at the threshold go either way with the rounding of another machine."""
ROWS = certified_inertia.rows(certified_inertia.PAGE.read_text("utf-8"))
QUICK_ROWS = [row for row in ROWS if float(row[9]) < QUICK]


def test_every_joint_stands_on_the_page():
    named = [(arm.name, arm.reading, joint) for arm in certified_inertia.arms() for joint in arm.joint_names]
    assert [tuple(row[:3]) for row in ROWS] == named


def test_every_gap_is_as_asked():
    for row in ROWS:
        assert float(row[4]) <= 1e-6
        assert float(row[7]) <= 1e-9
        assert float(row[10]) < 1e-11
    assert max(float(row[6]) for row in ROWS) < 10.0


@pytest.mark.slow
@pytest.mark.parametrize("place", np.random.default_rng(SEED).choice(len(QUICK_ROWS), SHARE, replace=False))
def test_a_share_is_proven_again(place):
    robot, reading, joint, value, *numbers, rounding = QUICK_ROWS[place]
    arm = lwr_dyn.load(robot, reading=reading)
    maximum = worst_case_inertias(arm)[arm.joint_names.index(joint)]
    assert f"{maximum.value:.9g}" == value
    for gap, (shown, boxes, _) in zip(certified_inertia.GAPS, (numbers[:3], numbers[3:]), strict=True):
        proven = inertia_certificate(arm, maximum, gap)
        assert proven.holds
        assert proven.gap == pytest.approx(float(shown), rel=0.2, abs=1e-12)
        assert abs(proven.boxes - int(boxes)) <= BOXES * int(boxes)
    assert proven.allowance / maximum.value == pytest.approx(float(rounding), rel=1.0)
