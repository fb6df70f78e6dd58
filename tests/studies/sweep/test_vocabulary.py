"""Which side of a bound is bad, joints, and runs that diverged."""

import numpy as np
import pytest

from lwr_dyn.foundation.errors import OptionError, UnknownNameError
from lwr_dyn.model.chain import JointKind
from lwr_dyn.studies.sweep.vocabulary import METRICS, PATHS, metric_words, parameter_path


def test_the_worst_joint_counts_and_no_number_is_the_worst_of_all():
    torque = metric_words("peak_torque")
    assert torque.badness(np.array([[1.0, 3.0], [np.nan, 2.0]])).tolist() == [3.0, np.inf]
    margin = metric_words("limit_margin")
    assert margin.badness(np.array([[0.5, -0.1], [0.3, 0.4]])).tolist() == [0.1, -0.3]
    assert margin.shown(-0.3) == pytest.approx(300.0)


def test_bounds_of_either_side():
    tip = metric_words("tip_max")
    assert tip.is_within(np.array([1e-3, 2e-3, np.nan, np.inf]), 1e-3).tolist() == [True, False, False, False]
    violation = metric_words("first_violation")
    assert violation.is_within(np.array([np.inf, 3.0, 5.0, np.nan]), 4.0).tolist() == [True, False, True, False]
    assert violation.is_within(np.array([np.inf, 3.0]), np.inf).tolist() == [True, False]


def test_quantiles_over_time_belong_to_the_study():
    assert metric_words("tip_q95", (0.95,)).unit == "mm"
    with pytest.raises(UnknownNameError, match="tip_q95"):
        metric_words("tip_q9", (0.95,))


def test_a_path_has_its_bounds_and_its_nominal_value():
    factor, known = "a number above 0", "a number from 0 to 1"
    length, torque = "a number, in m", "a number from 0 on, in N m s/rad"
    encoder, samples = "a number from 0 on, in rad or m", "a whole number from 0 to 8, in samples"
    assert {path: (row.allowed, row.nominal) for path, row in PATHS.items() if "OPTION" not in path} == {
        "reading": ("a number", None), "arm.mass": (factor, 1.0), "arm.inertia": (factor, 1.0),
        "arm.com": (length, 0.0),
        "arm.armature": ("a number from 0 on", 1.0), "payload.mass": ("a number from 0 on, in kg", 0.0),
        "payload.com": (length, 0.0), "payload.known": (known, 0.0), "friction.coulomb": ("a number from 0 on", 0.0),
        "friction.viscous": (torque, 0.0), "sensor.resolution": (encoder, 0.0), "sensor.noise": (encoder, 0.0),
        "loop.delay": (samples, 0.0), "limits.torque": (factor, 1.0),
    }  # fmt: skip
    assert [PATHS["loop.delay"].allows(x) for x in (0.0, 8.0, 9.0, 0.5, -1.0, np.nan)] == [True] * 2 + [False] * 4
    assert [PATHS["arm.mass"].allows(x) for x in (0.0, 1e-9, np.inf)] == [False, True, False]
    assert PATHS["arm.armature"].allows(0.0)


@pytest.mark.parametrize(
    ("text", "columns"),
    [
        ("arm.mass", ("arm.mass.1", "arm.mass.2")), ("arm.mass.all", ("arm.mass.all",)),
        ("arm.com.2", ("arm.com.2.x", "arm.com.2.y", "arm.com.2.z")), ("arm.com.all.y", ("arm.com.all.y",)),
        ("payload.com", ("payload.com.x", "payload.com.y", "payload.com.z")), ("payload.com.z", ("payload.com.z",)),
        ("controller.omega-n", ("controller.omega-n",)), ("loop.delay", ("loop.delay",)),
    ],
)  # fmt: skip
def test_a_path_names_its_numbers(text, columns):
    assert parameter_path(text, 2).columns(2) == columns


@pytest.mark.parametrize(
    ("text", "error", "words"),
    [
        ("arm.mass.3", OptionError, "'3'; allowed: the number of a link, from 1 to 2, or all"),
        ("arm.mass.2.x", OptionError, "'arm.mass.2.x'; allowed: arm.mass or arm.mass.all or arm.mass.3"),
        ("arm.com.2.x.x", OptionError, "allowed: arm.com or arm.com.all or arm.com.3 or arm.com.3.z"),
        ("payload.com.x.y", OptionError, "allowed: payload.com or payload.com.z"),
        ("payload.mass.x", OptionError, "'payload.mass.x'; allowed: payload.mass"),
        ("controller", UnknownNameError, "parameter path"), ("arm.masses", UnknownNameError, "arm.mass"),
    ],
)  # fmt: skip
def test_a_path_that_is_none(text, error, words):
    with pytest.raises(error, match=words):
        parameter_path(text, 2)


def test_a_metric_has_a_unit_for_people_by_the_joints_and_a_side():
    sides = {name: metric_words(name).worse for name in METRICS}
    assert [name for name, side in sides.items() if side == -1] == ["limit_margin", "first_violation"]
    assert [name for name, row in METRICS.items() if not row.per_joint] == [
        "tip_rms", "tip_max", "tip_final", "first_violation"
    ]  # fmt: skip
    assert ([x for x in METRICS if METRICS[x].signed], [x for x in METRICS if METRICS[x].needs_effort]) == (
        ["limit_margin"], ["saturated_s"],
    )  # fmt: skip
    turning, sliding = [JointKind.REVOLUTE] * 2, [JointKind.PRISMATIC]
    units = {
        "position_rms": [("mrad or mm", 1e3), ("mrad", 1e3), ("mm", 1e3), ("mrad or mm", 1e3)],
        "peak_torque": [("N m or N", 1.0), ("N m", 1.0), ("N", 1.0), ("N m or N", 1.0)],
        "saturated_s": [("s", 1.0)] * 4,
    }
    for name, wanted in units.items():
        found = [metric_words(name, (), kinds) for kinds in ((), turning, sliding, [*turning, *sliding])]
        assert [(one.unit, one.factor) for one in found] == wanted
    assert metric_words("peak_torque").title == "largest torque that acts, worst joint"
    assert metric_words("tip_q95", (0.5, 0.95)).title == "error of the tip, 95 % quantile over time"
