"""The working envelope: exact integral against a count of cells, reach, closed outline, bad input."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import lwr_dyn
import lwr_dyn.arms.papers
from lwr_dyn.checks.datasheet.envelope import EnvelopeArc, working_envelope
from lwr_dyn.foundation.errors import MissingDataError, OptionError
from lwr_dyn.model.arm import JointLimits

CELL = 0.002
"""[m] A raster of this size is off by less than `RASTER`."""
RASTER = 0.004
"""[m^3] Cells cut by ten metres of outline, half of them in, half out."""


@pytest.fixture(scope="module")
def kr30():
    return lwr_dyn.load("kr30ha")


def raster_volume(low2, up2, low3, up3, sides=(1,), offset=0.35):
    """The volume by counting cells, from the paper's lengths and KUKA's axes alone; side -1 is behind axis 1."""
    r, z = np.meshgrid(np.arange(CELL / 2, 2.1, CELL), np.arange(-1.2 + CELL / 2, 2.6, CELL))
    inside = np.any([reached(side * r - offset, z - 0.815, low2, up2, low3, up3) for side in sides], axis=0)
    return float(2 * np.pi * (r * inside).sum() * CELL**2)


def reached(x, y, low2, up2, low3, up3):
    """Whether joints 2 and 3 [deg] bring the wrist centre to x, y [m] from axis 2."""
    first, second = 0.85, np.hypot(0.145, 0.82)
    lean = np.arctan2(0.145, 0.82)
    cosine = (x**2 + y**2 - first**2 - second**2) / (2 * first * second)
    inside = np.zeros(x.shape, dtype=bool)
    for sign in (1, -1):
        bend = sign * np.arccos(np.clip(cosine, -1, 1))
        a2 = -np.arctan2(y, x) + np.arctan2(-second * np.sin(bend), first + second * np.cos(bend))
        ok = np.abs(cosine) <= 1
        for angle, low, up in ((a2, low2, up2), (lean + bend, low3, up3)):
            ok &= np.mod(angle - np.radians(low), 2 * np.pi) <= np.radians(up - low)
        inside |= ok
    return inside


def with_ranges(arm, **ranges):
    """Other limits [deg] of joints by name."""
    limits = [
        replace(x, lower=np.radians(ranges[n][0]), upper=np.radians(ranges[n][1])) if n in ranges else x
        for n, x in zip(arm.joint_names, arm.limits, strict=True)
    ]
    return replace(arm, limits=tuple(limits))


@pytest.mark.slow
def test_the_data_sheet_and_what_is_reached_overhead(kr30):
    result = working_envelope(kr30)
    assert result.volume == pytest.approx(27.24, abs=0.02)
    assert result.reach == pytest.approx(0.35 + 0.85 + np.hypot(0.145, 0.82), abs=1e-12)
    every = raster_volume(-135, 35, -120, 158, sides=(1, -1))
    assert result.volume_with_overhead == pytest.approx(every, abs=RASTER)
    assert result.volume_with_overhead - result.volume == pytest.approx(1.0997, abs=1e-4)
    q = np.random.default_rng(1).uniform(kr30.lower, kr30.upper, (20_000, 6))
    q[:, 0] = 0.0
    T = lwr_dyn.forward_kinematics(kr30, q)
    behind = -(T[:, 0, 3] - 0.17 * T[:, 0, 2]).min()
    assert result.reach_behind - 0.02 < behind <= result.reach_behind
    assert "reaches 1083.76 mm behind axis 1 and 1.0997 m^3 more, 28.3425 m^3 in all" in result.overhead


@pytest.mark.slow
@pytest.mark.parametrize(
    ("a2", "a3"),
    [((-135, 35), (-120, 158)), ((-90, 0), (-30, 60)), ((-135, 35), (20, 158)), ((-60, 80), (-170, -20)),
     ((-135, 35), (-168, 158))],
)  # fmt: skip
def test_ranges(kr30, a2, a3):
    result = working_envelope(with_ranges(kr30, A2=a2, A3=a3))
    assert result.volume == pytest.approx(raster_volume(*a2, *a3), abs=RASTER)


def test_less_of_axis_1_is_less_volume(kr30):
    half = working_envelope(with_ranges(kr30, A1=(-90, 90)))
    assert half.volume == pytest.approx(working_envelope(kr30).volume / 2)


@pytest.mark.slow
def test_half_a_turn_of_axis_1_adds_the_other_side_whole(kr30):
    """Ahead and behind are then half a turn apart and nowhere the same point."""
    half = working_envelope(with_ranges(kr30, A1=(-90, 90)))
    behind = raster_volume(-135, 35, -120, 158, sides=(-1,))
    assert half.volume_with_overhead == pytest.approx(half.volume + behind / 2, abs=RASTER)


@pytest.mark.slow
def test_an_arm_over_axis_1_reaches_as_far_behind(tmp_path):
    """Ahead and behind have arcs on the same circles: each counts once."""
    printed = (Path(lwr_dyn.arms.papers.__file__).parent / "kr30ha.toml").read_text(encoding="utf-8")
    own = tmp_path / "own.toml"
    own.write_text(printed.replace("values = [350, 850, 145", "values = [0, 850, 145"), encoding="utf-8")
    result = working_envelope(with_ranges(lwr_dyn.load(own), A2=(-150, -30), A3=(-120, 158)))
    assert result.volume == pytest.approx(raster_volume(-150, -30, -120, 158, offset=0.0), abs=RASTER)
    every = raster_volume(-150, -30, -120, 158, sides=(1, -1), offset=0.0)
    assert result.volume_with_overhead == pytest.approx(every, abs=RASTER)


def test_every_wrist_centre_is_within_the_outline_and_it_is_closed(kr30):
    result = working_envelope(kr30)
    ends = {tuple(np.round(arc.point(arc.end), 9)) for arc in result.outline}
    starts = {tuple(np.round(arc.point(arc.start), 9)) for arc in result.outline}
    assert all(abs(r) < 1e-9 for r, _ in ends ^ starts)
    q = np.random.default_rng(0).uniform(kr30.lower, kr30.upper, (5000, 6))
    T = lwr_dyn.forward_kinematics(kr30, q)
    wrist = T[:, :3, 3] - 0.17 * T[:, :3, 2]
    assert np.hypot(wrist[:, 0], wrist[:, 1]).max() <= result.reach + 1e-12


def test_the_moment_of_a_ring_and_bad_input(kr30):
    ring = EnvelopeArc((2.0, 1.0), 0.5, 0.0, 2 * np.pi)
    assert np.pi * ring.moment() == pytest.approx(2 * np.pi * 2.0 * np.pi * 0.25)  # Pappus
    with pytest.raises(OptionError, match="spherical wrist"):
        working_envelope(lwr_dyn.load("lwr4plus"))
    with pytest.raises(MissingDataError, match="limits of joints 1 to 3"):
        working_envelope(replace(kr30, limits=(JointLimits(), *kr30.limits[1:])))
