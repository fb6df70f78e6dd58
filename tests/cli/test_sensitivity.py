"""`lwr-dyn sensitivity`: its tables, its JSON, one line for bad input."""

import pytest

from tests.json_schemas import faults

QUICK = ("--task", "joint-move", "--rate", "250", "--poses", "20")


@pytest.mark.slow
def test_tables(printed):
    out = printed("sensitivity", "kr30ha", *QUICK)
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
def test_json(recorded):
    record = recorded("sensitivity", "kr30ha", *QUICK)
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
def test_bad_input(arguments, message, refused):
    assert message in refused("sensitivity", *arguments)
