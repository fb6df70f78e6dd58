"""`lwr-dyn reproduce`: one JSON object; one line for bad input and nothing half-written."""

import json

import pytest

from tests.json_schemas import faults


@pytest.mark.slow
def test_reproduce_the_exercise(lwr_dyn_command, tmp_path):
    code, out, _ = lwr_dyn_command("reproduce", "lwr4", "--out", str(tmp_path / "o"), "--json")
    assert code == 0
    assert faults("reproduce", json.loads(out)) == []
    assert json.loads(out)["tool"] == pytest.approx([-0.3, -0.39, -0.05])
    assert {p.name for p in (tmp_path / "o").iterdir()} >= {"tables.txt", "results.json", "report.html", "models"}


def test_reproduce_into_a_folder_that_cannot_be_made(lwr_dyn_command, tmp_path):
    (tmp_path / "file").write_text("mine")
    code, _, err = lwr_dyn_command("reproduce", "lwr4", "--out", str(tmp_path / "file" / "x"))
    assert code == 2
    assert err.count("\n") == 1
    assert "allowed: a directory that exists or can be made, and can be written" in err
    code, _, err = lwr_dyn_command("reproduce", "lwr4plus", "--timing", "slow", "--out", str(tmp_path / "x"))
    assert "timing: 'slow'; allowed: constant, quintic, smooth" in err
    assert [p.name for p in tmp_path.iterdir()] == ["file"]


def test_a_paper_that_is_not_there(lwr_dyn_command):
    code, out, err = lwr_dyn_command("reproduce", "lwr5")
    assert (code, out) == (2, "")
    assert "no paper to reproduce named 'lwr5'" in err
