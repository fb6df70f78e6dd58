"""`lwr-dyn reproduce`: one JSON object; one line for bad input and nothing half-written."""

import pytest

from tests.json_schemas import faults


@pytest.mark.slow
def test_reproduce_the_exercise(recorded, tmp_path):
    record = recorded("reproduce", "lwr4", "--out", str(tmp_path / "o"))
    assert faults("reproduce", record) == []
    assert record["tool"] == pytest.approx([-0.3, -0.39, -0.05])
    assert {p.name for p in (tmp_path / "o").iterdir()} >= {"tables.txt", "results.json", "report.html", "models"}


def test_reproduce_into_a_folder_that_cannot_be_made(refused, tmp_path):
    (tmp_path / "file").write_text("mine")
    said = refused("reproduce", "lwr4", "--out", str(tmp_path / "file" / "x"))
    assert "allowed: a directory that exists or can be made, and can be written" in said
    said = refused("reproduce", "lwr4plus", "--timing", "slow", "--out", str(tmp_path / "x"))
    assert "timing: 'slow'; allowed: constant, quintic, smooth" in said
    assert [p.name for p in tmp_path.iterdir()] == ["file"]


def test_a_paper_that_is_not_there(refused):
    assert "no paper to reproduce named 'lwr5'" in refused("reproduce", "lwr5")
