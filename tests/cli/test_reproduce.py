"""`lwr-dyn reproduce`: one JSON object; one line for bad input and nothing half-written."""

import pytest

from tests.json_schemas import faults
from tests.reproduction.two_links import RESULTS, TEXT


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
    assert "'--timing': 'slow' is not one of 'constant', 'quintic', 'smooth'" in said
    assert [p.name for p in tmp_path.iterdir()] == ["file"]


def test_a_paper_that_is_not_there(refused):
    assert "no paper to reproduce named 'lwr5'" in refused("reproduce", "lwr5")
    assert "a path to a .toml with [[result]]" in refused("reproduce", "lwr5")


def test_a_paper_of_ones_own(recorded, lwr_dyn_command, folder):
    """Into out/NAME of the file; exit 1 and the verdict in words when a number differs."""
    (folder / "two.toml").write_text(TEXT + RESULTS, encoding="utf-8")
    record = recorded("reproduce", "two.toml")
    assert faults("reproduce", record) == []
    assert (record["holds"], record["counts"]["printed"]["all"]) == (True, 5)
    assert (folder / "out" / "two" / "report.html").is_file()
    (folder / "two.toml").write_text(TEXT + RESULTS.replace("0.930", "0.950"), encoding="utf-8")
    code, out, err = lwr_dyn_command("reproduce", "two.toml")
    assert (code, err) == (1, "")
    assert "differs by -0.02, -20 last digits" in out


def test_a_paper_of_ones_own_that_cannot_be_read(refused, folder):
    assert "mine.toml: " in refused("reproduce", "mine.toml")
    (folder / "two.toml").write_text(TEXT, encoding="utf-8")
    assert "two.toml: result: missing; allowed: tables [[result]]" in refused("reproduce", "two.toml")
    (folder / "two.toml").write_text(TEXT + RESULTS, encoding="utf-8")
    said = refused("reproduce", "two.toml", "--timing", "quintic")
    assert "timing: given for two.toml; allowed: only for lwr4plus" in said
    assert [p.name for p in folder.iterdir()] == ["two.toml"]
