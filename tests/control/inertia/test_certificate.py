"""Certificates: no position has more than the bound, and the search's value is as near to it as asked."""

from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.control.inertia.bernstein import InertiaTable
from lwr_dyn.control.inertia.certificate import InertiaCertificate, inertia_certificate, inertia_certificates
from lwr_dyn.control.inertia.worst_case import diagonal, first_joint, worst_case_inertia, worst_case_inertias
from lwr_dyn.design.gain_search import certificates
from lwr_dyn.dynamics.newton_euler import Recursion
from lwr_dyn.foundation.errors import MissingPackageError, OptionError
from lwr_dyn.model.arm import JointLimits
from tests.random_arms import random_arm


@pytest.mark.slow
@pytest.mark.parametrize(("robot", "gap"), [("lwr4plus", 1e-9), ("kr30ha", 1e-6), ("wam7", 1e-6)])
def test_joints_behind_the_first_and_the_first_of_the_lwr(robot, gap):
    arm = lwr_dyn.load(robot)
    maxima = worst_case_inertias(arm)[1:]
    for maximum, certificate in zip(maxima, inertia_certificates(arm, maxima, gap), strict=True):
        assert certificate.holds
        assert maximum.value == certificate.value <= certificate.upper <= maximum.value * (1 + gap)
        assert certificate.allowance < 1e-11 * certificate.value
        assert "certified" in certificate.statement()
    if robot == "lwr4plus":
        assert 0.0 < inertia_certificate(arm, worst_case_inertia(arm, 0)).gap < 1e-6


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(6))
def test_no_position_of_a_random_arm_has_more(seed):
    rng = np.random.default_rng(seed)
    kinds = "".join(rng.choice(["R", "R", "P"], 5))
    limits = tuple(JointLimits(-float(x), float(y)) for x, y in rng.uniform(0.2, 2.5, (5, 2)))
    arm = replace(random_arm(seed, kinds), limits=limits)
    q = rng.uniform(arm.lower, arm.upper, (20_000, 5))
    for joint in (0, 1):
        maximum = worst_case_inertia(arm, joint)
        certificate = inertia_certificate(arm, maximum, 1e-6)
        assert diagonal(Recursion.of(arm.chain), joint, q).max() <= certificate.upper
        assert certificate.holds
        assert certificate.upper <= maximum.value * (1 + 1e-6)


def test_a_certificate_says_what_is_proven_in_words_and_as_json():
    numbers = {"value": 2.0, "upper": 2.5, "boxes": 7, "allowance": 1e-9, "left_out": 3e-5}
    asked, kept = (InertiaCertificate(joint=1, gap_asked=gap, **numbers) for gap in (0.1, 0.25))
    words = "certified: nowhere in the joint box above 2.5, a gap of 2.5e-01{} (7 boxes, 5e-10 of it for rounding)"
    assert [x.statement() for x in (asked, kept)] == [words.format(", NOT as asked, 1.0e-01"), words.format("")]
    assert [x.holds for x in (asked, kept)] == [False, True]
    assert kept.to_json() == {**numbers, "gap": 0.25}
    assert replace(kept, value=0.0).gap == 0.0


def test_without_the_extra_nothing_is_certified(arm, monkeypatch):
    def absent():
        raise MissingPackageError("llvmlite", "batch")

    monkeypatch.setattr("lwr_dyn.control.inertia.certificate._proven", {})
    monkeypatch.setattr("lwr_dyn.codegen.kernels.box_search.box_search", absent)
    maximum = worst_case_inertia(arm, 6)
    assert certificates(arm, [maximum]) is None
    with pytest.raises(MissingPackageError, match=r"lwr_dyn\[batch\]"):
        inertia_certificate(arm, maximum)


def test_a_search_that_missed_the_maximum_is_corrected(arm):
    maximum = worst_case_inertia(arm, 1)
    low = replace(maximum, value=0.9 * maximum.value)
    certificate = inertia_certificate(arm, low)
    assert certificate.upper >= maximum.value
    assert low.value < certificate.value <= maximum.value * (1 + 1e-12)


def test_the_bound_holds_without_time_to_close_the_gap(arm, monkeypatch):
    monkeypatch.setattr("lwr_dyn.control.inertia.certificate.MOST_BOXES", 40)
    maximum = worst_case_inertia(arm, 2)
    certificate = inertia_certificate(arm, maximum, 1e-9)
    assert not certificate.holds
    assert certificate.upper > maximum.value * (1 + 1e-9)
    assert "NOT as asked" in certificate.statement()


def test_a_range_longer_than_a_turn_is_that_of_one_turn(arm):
    """B_ii repeats after a turn: four turns of each joint need no more boxes, and the bound is that of one."""

    def bound(turns):
        limits = JointLimits(lower=-turns * np.pi, upper=turns * np.pi)
        free = replace(arm, limits=(limits,) * arm.n)
        found = inertia_certificate(free, worst_case_inertia(free, 3))
        assert found.holds
        return found

    one, many = bound(1), bound(4)
    assert many.upper == pytest.approx(one.upper, rel=2e-6)
    assert many.boxes < 1.5 * one.boxes


def test_the_whole_turn_is_looked_at(arm):
    """The maximum lies in the last tenth of the first turn, and a search that missed it is corrected."""
    best = worst_case_inertia(arm, 3)
    lower = best.q - 0.95 * 2.0 * np.pi
    free = replace(arm, limits=tuple(JointLimits(lower=x, upper=x + 6.0 * np.pi) for x in lower))
    missed = replace(worst_case_inertia(free, 3), value=0.5 * best.value)
    assert inertia_certificate(free, missed).value == pytest.approx(best.value, rel=2e-6)


def test_certificates_are_kept_by_the_content_of_the_arm(arm, monkeypatch):
    maximum = worst_case_inertia(arm, 4)
    first = inertia_certificate(arm, maximum)
    assert inertia_certificate(arm, worst_case_inertia(arm, 6)).boxes == 1
    assert inertia_certificate(lwr_dyn.load("lwr4plus"), worst_case_inertia(arm, 4)) is first
    assert inertia_certificate(arm, maximum, 1e-7).gap_asked == 1e-7
    wider = replace(arm, limits=tuple(JointLimits(2 * x.lower, 2 * x.upper) for x in arm.limits))
    assert inertia_certificate(wider, maximum) is not first
    monkeypatch.setattr("lwr_dyn.control.inertia.certificate.KEPT", 1)
    monkeypatch.setattr("lwr_dyn.control.inertia.certificate._proven", {})
    again = inertia_certificate(arm, maximum)
    assert inertia_certificate(arm, maximum) is again
    inertia_certificate(arm, maximum, 1e-7)
    assert inertia_certificate(arm, maximum) is not again


def test_the_table_is_that_of_the_mass_matrix(arm):
    table = InertiaTable.of(replace(first_joint(arm, {}), joint=3))
    assert table.joints == (4, 5, 6)
    q = np.zeros(7)
    q[4], q[6] = 2 * np.pi / 5, 6 * np.pi / 5
    B = lwr_dyn.dynamics_of(arm).mass_matrix(q)
    assert float(table.values[1, 0, 3]) == pytest.approx(B[3, 3], rel=1e-14)
    idle = table.without_idle(1e-3 * B[3, 3])
    assert idle.left_out > 0.0
    assert len(idle.joints) < 3
    slides = replace(random_arm(1, "RPRR"), limits=(JointLimits(lower=-0.5, upper=0.4),) * 4)
    table = InertiaTable.of(first_joint(slides, {}))
    idle = table.without_idle(np.inf)
    assert (idle.joints, idle.is_turning, idle.lower, idle.upper) == ((1,), (False,), (-0.5,), (0.4,))
    assert np.abs(table.values - idle.values[:, None, None]).max() <= idle.left_out


@pytest.mark.parametrize("gap", [0.0, -1.0, 1.0, float("nan")])
def test_a_gap_that_cannot_be_and_too_many_joints(arm, gap):
    with pytest.raises(OptionError, match="gap"):
        inertia_certificate(arm, worst_case_inertia(arm, 5), gap)
    with pytest.raises(OptionError, match="joints behind"):
        InertiaTable.of(first_joint(random_arm(3, "R" * 10), {}))
