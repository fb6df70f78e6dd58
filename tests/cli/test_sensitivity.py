"""`lwr-dyn sensitivity`: its tables, its JSON, one line for bad input."""

import json

import pytest

from lwr_dyn.cli.main import main
from tests.json_schemas import faults

QUICK = ("--task", "joint-move", "--rate", "250", "--poses", "20")


def run(*arguments):
    with pytest.raises(SystemExit) as stop:
        main(["sensitivity", *arguments])
    return stop.value.code


@pytest.mark.slow
def test_tables(capsys):
    assert run("kr30ha", *QUICK) == 0
    out = capsys.readouterr().out
    for words in (
        "gravity torques at 20 poses",
        "8 runs of 4 s at 250",
        "inverse dynamics with feed-forward  on kuka",
        "tip (rigid links and joints)",
        "what survives",
    ):
        assert words in out, words
    assert "speeds keep to their limits" in out
    assert "torques keep" not in out  # the maker names no torque limits


@pytest.mark.slow
def test_json(capsys):
    assert run("kr30ha", *QUICK, "--json") == 0
    record = json.loads(capsys.readouterr().out)
    assert faults("sensitivity", record) == []
    assert record["readings"] == ["kuka", "printed"]
    assert len(record["runs"]) == 8
    assert {run["controller"] for run in record["runs"]} == {
        "PD + gravity, damping on dq", "inverse dynamics with feed-forward",
    }  # fmt: skip
    assert record["conclusions"][0]["holds"][0]["case"] == ["kuka", "kuka"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("lwr4",), "one reading"),
        (("lwr4plus", "kr30ha"), "joints"),
        (("nobody",), "no robot named"),
        (("lwr4plus", "lwr4plus"), "twice"),
        (("nofile.toml", "lwr4plus"), "nofile.toml"),
        (("kr30ha", "--task", "ist"), "allowed"),
        (("kr30ha", "--rate", "-1"), "rate"),
    ],
)
def test_bad_input(arguments, message, capsys):
    assert run(*arguments) == 2
    captured = capsys.readouterr()
    assert message in captured.err
    assert captured.err.count("\n") == 1
