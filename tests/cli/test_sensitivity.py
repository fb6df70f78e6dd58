"""`lwr-dyn sensitivity`: the arms and options that are compared, its tables, one line for bad input."""

from types import SimpleNamespace

import pytest

import lwr_dyn
from lwr_dyn.checks.sensitivity.analysis import POSES
from lwr_dyn.foundation.document import Document

QUICK = ("--task", "joint-move", "--rate", "250", "--poses", "20")


@pytest.mark.parametrize(
    ("words", "names", "options"),
    [
        (("kr30ha",), {"kuka": "kuka", "printed": "printed"}, (None, 1000.0, POSES)),
        (("kr30ha", *QUICK), {"kuka": "kuka", "printed": "printed"}, ("joint-move", 250.0, 20)),
        (("lwr4", "own.urdf"), {"lwr4 printed": "printed", "own": "urdf"}, (None, 1000.0, POSES)),
    ],
)
def test_readings_and_files_are_compared_by_names_that_differ(asked, printed, folder, words, names, options):
    (folder / "own.urdf").write_text(lwr_dyn.urdf_text(lwr_dyn.load("lwr4")))
    calls = asked("lwr_dyn.cli.sensitivity.sensitivity", SimpleNamespace(document=Document("", "compared", ())))
    assert printed("sensitivity", *words).splitlines()[-1] == "compared"
    (arms, task), given = calls[0]
    assert {name: arm.reading for name, arm in arms.items()} == names
    assert (task, given["rate"], given["poses"]) == options


@pytest.mark.slow
def test_tables_and_record(printed, recorded):
    out = printed("sensitivity", "kr30ha", *QUICK)
    for words in (
        "gravity torques at 20 poses", "8 runs of 4 s at 250", "inverse dynamics with feed-forward  on kuka",
        "tip (rigid links and joints)", "what survives", "speeds keep to their limits",
    ):  # fmt: skip
        assert words in out, words
    assert "torques keep" not in out  # the maker names no torque limits
    record = recorded("sensitivity", "kr30ha", *QUICK)
    assert (record["readings"], len(record["runs"])) == (["kuka", "printed"], 8)
    assert {run["controller"] for run in record["runs"]} == {
        "PD + gravity, damping on dq", "inverse dynamics with feed-forward",
    }  # fmt: skip
    assert record["conclusions"][0]["holds"][0]["case"] == ["kuka", "kuka"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("lwr4",), "robots: lwr4 has one reading; allowed: a robot with several readings, or several robots"),
        (("lwr4plus", "kr30ha"), "joints"),
        (("nobody",), "no robot named"),
        (("lwr4plus", "lwr4plus"), "robots: lwr4plus physical twice; allowed: different names"),
        (("nofile.toml", "lwr4plus"), "nofile.toml"),
        (("kr30ha", "--task", "ist"), "allowed"),
        (("kr30ha", "--rate", "-1"), "rate"),
    ],
)
def test_bad_input(arguments, message, refused):
    assert message in refused("sensitivity", *arguments)
