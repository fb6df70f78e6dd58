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
