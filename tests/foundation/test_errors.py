"""Every error writes one sentence and keeps its facts as attributes."""

import pytest

from lwr_dyn.foundation import errors

SENTENCES = [
    (errors.ShapeError("q", "shape (3,)", "(..., 7)"), "q: shape (3,); allowed: (..., 7)"),
    (errors.OptionError("port", 70000, "0..65535"), "port: 70000; allowed: 0..65535"),
    (errors.PaperError("a.toml", "dh.a", "missing", "a column"), "a.toml: dh.a: missing; allowed: a column"),
    (errors.UrdfError("a.urdf", "robot", "no name", "a name"), "a.urdf: robot: no name; allowed: a name"),
    (errors.FileAccessError("a.npz", "no such file", "a run file"), "a.npz: no such file; allowed: a run file"),
    (errors.PathLimitError(0.5, "point 1", "too far", "nearer"), "at t = 0.5 s, point 1: too far; allowed: nearer"),
    (
        errors.DivergenceError(2.0, "joint_1", "1e9 rad", "below 1e6 rad"),
        "the simulation diverges at t = 2 s: joint_1: 1e9 rad; allowed: below 1e6 rad",
    ),
]


POSE = ("a", 0.25, 0.125, (1.0,))
OTHERS = [
    (errors.OutOfReachError("a", 1.25, 0.5, "row"), {"arm": "a", "at": 1.25, "distance": 0.5},
     "the path leaves the reach of a at row = 1.25, by 0.5 m; allowed: a path whose wrist centre stays within reach"),
    (errors.PoseNotReachedError(*POSE, None, 0.0), {"distance": 0.25, "angle": 0.125, "q": (1.0,), "joint": None},
     "a does not reach the pose: the nearest position found is 0.25 m and 0.125 rad off; "
     "allowed: a pose that the arm reaches, or another q0"),
    (errors.PoseNotReachedError(*POSE, "A2", 0.75), {"arm": "a", "joint": "A2", "excess": 0.75},
     "a does not reach the pose: A2 is outside its limits by 0.75 in the nearest solution found; "
     "allowed: another pose or q0, or limits=False"),
    (errors.OutsideLimitsError("a", 0.5, "A2", 0.25, "b"), {"at": 0.5, "joint": "A2", "excess": 0.25, "why": "b"},
     "the path leaves the limits of a at s = 0.5: A2 is outside by 0.25 rad (b); allowed: a path inside the limits"),
    (errors.MissingPackageError("x", "", "y"), {"package": "x", "extra": ""},
     "x is not installed; install it with: pip install 'lwr_dyn'; without it: y"),
    (errors.LogError("a.csv", "row 2", "3 cells", "2 cells"), {"file": "a.csv", "where": "row 2", "needed": "2 cells"},
     "a.csv: row 2: 3 cells; needed: 2 cells"),
    (errors.MissingDataError("a", "masses", "dynamics"), {"arm": "a", "missing": "masses", "needed_for": "dynamics"},
     "a: masses not given; needed for dynamics"),
    (errors.SingularMassError(2), {"joint": 2},
     "forward dynamics: joint 2 moves no inertia; allowed: mass or a rotor at or beyond each joint"),
    (errors.SingularArmError(3, "stretched"), {"index": 3, "why": "stretched"},
     "row 3 of the path: stretched; allowed: poses and arm angles away from singularities"),
    (errors.NotPhysicalError("a", ["l1", "l2"]), {"arm": "a", "links": ("l1", "l2")},
     "a: the inertia of l1, l2 is not physical; allowed: a body that can exist (lwr-dyn check), another reading, "
     "or allow_unphysical (simulate --allow-unphysical)"),
]  # fmt: skip


@pytest.mark.parametrize(("error", "facts", "sentence"), OTHERS)
def test_other_errors_are_one_sentence_and_keep_their_facts(error, facts, sentence):
    assert str(error) == sentence
    assert {name: getattr(error, name) for name in facts} == facts


@pytest.mark.parametrize(("error", "sentence"), SENTENCES)
def test_a_fault_is_one_sentence_with_what_is_allowed(error, sentence):
    assert str(error) == sentence
    assert isinstance(error, errors.FaultError)
    assert sentence == f"{error.name}: {error.found}; allowed: {error.allowed}"


def test_errors_keep_their_facts_and_have_a_built_in_parent():
    paper = errors.PaperError("a.toml", "dh.a", "missing", "a column")
    assert (paper.file, paper.field, paper.found, paper.allowed) == ("a.toml", "dh.a", "missing", "a column")
    assert isinstance(paper, ValueError)
    limit = errors.PathLimitError(0.5, "point 1", "too far", "nearer", "joint_2", 0.1)
    assert (limit.t, limit.where, limit.fault, limit.joint, limit.excess) == (0.5, "point 1", "too far", "joint_2", 0.1)
    assert isinstance(errors.FileAccessError("a", "b", "c"), OSError)


def test_an_unknown_name_comes_with_the_nearest_known_one():
    error = errors.UnknownNameError("robot", "lwr4pls", ("lwr4plus", "wam7"))
    assert error.known == ("lwr4plus", "wam7")
    assert "did you mean lwr4plus?" in str(error)
    assert str(errors.UnknownNameError("reading", None, ())) == "no reading named 'None'; known: none"
