"""`lwr-dyn reproduce`: one JSON object; one line for bad input and nothing half-written."""

from types import SimpleNamespace

import pytest

from lwr_dyn.foundation.document import Document
from tests.reproduction.two_links import RESULTS, TEXT


@pytest.mark.parametrize(
    ("words", "paper", "folder_of", "options", "page"),
    [
        (("lwr4plus", "--timing", "quintic"), "lwr4plus", "out/lwr4plus", "quintic", True),
        (("lwr4", "--out", "there"), "lwr4", "there", None, True),
        (("my/own.toml",), "my/own.toml", "out/own", None, True),
        (("all",), "all", "out", None, False),
        (("panda",), "panda", "out/panda", None, False),
    ],
)
@pytest.mark.parametrize("holds", [True, False])
def test_where_it_goes_and_whether_it_holds(asked, lwr_dyn_command, words, paper, folder_of, options, page, holds):
    found = SimpleNamespace(document=Document("", "again", ()), holds=holds)
    calls = asked("lwr_dyn.reproduction.reproduce.reproduce", found)
    code, out, err = lwr_dyn_command("reproduce", *words)
    opened = f"; open it: xdg-open {folder_of}/report.html" if page else ""
    assert (code, out, err) == (0 if holds else 1, f"again\n\nwrote {folder_of}{opened}\n", "")
    assert (calls[0][0][:2], calls[0][1]["timing"]) == ((paper, folder_of), options)
    assert "wrote" not in lwr_dyn_command("reproduce", *words, "--json")[1]


@pytest.mark.slow
def test_reproduce_the_exercise(recorded, tmp_path):
    record = recorded("reproduce", "lwr4", "--out", str(tmp_path / "o"))
    assert record["tool"] == pytest.approx([-0.3, -0.39, -0.05])
    assert {p.name for p in (tmp_path / "o").iterdir()} >= {"tables.txt", "results.json", "report.html", "models"}


def test_a_paper_of_ones_own(recorded, lwr_dyn_command, folder):
    """Into out/NAME of the file; exit 1 and the verdict in words when a number differs."""
    (folder / "two.toml").write_text(TEXT + RESULTS, encoding="utf-8")
    record = recorded("reproduce", "two.toml")
    assert (record["holds"], record["counts"]["printed"]["all"]) == (True, 5)
    assert (folder / "out" / "two" / "report.html").is_file()
    (folder / "two.toml").write_text(TEXT + RESULTS.replace("0.930", "0.950"), encoding="utf-8")
    code, out, err = lwr_dyn_command("reproduce", "two.toml")
    assert (code, err, "differs by -0.02, -20 last digits" in out) == (1, "", True)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("lwr4", "--out", "file/x"), "allowed: a directory that exists or can be made, and can be written"),
        (("lwr4plus", "--timing", "slow", "--out", "x"), "'--timing': 'slow' is not one of 'constant', 'quintic', "),
        (("lwr5",), "no paper to reproduce named 'lwr5'"),
        (("lwr5",), "a path to a .toml with [[result]]"),
        (("mine.toml",), "mine.toml: "),
        (("bare.toml",), "bare.toml: result: missing; allowed: tables [[result]]"),
        (("two.toml", "--timing", "quintic"), "timing: given for two.toml; allowed: only for lwr4plus"),
    ],
)
def test_bad_input_is_one_line_and_nothing_is_half_written(refused, folder, arguments, said):
    (folder / "file").write_text("mine")
    (folder / "bare.toml").write_text(TEXT, encoding="utf-8")
    (folder / "two.toml").write_text(TEXT + RESULTS, encoding="utf-8")
    assert said in refused("reproduce", *arguments)
    assert sorted(p.name for p in folder.iterdir()) == ["bare.toml", "file", "two.toml"]
