"""`lwr-dyn krl check FOLDER`: each file with its own diagnostics, and the totals."""

import json
import os

import pytest


@pytest.fixture
def backup(folder):
    for name, text in {
        "R1/Program/a.src": "DEF a( )\nn = 1\nm = 2\nEND\n",
        "R1/Program/a.dat": "DEFDAT a\nINT n\nINT n\nENDDAT\n",
        "R1/Program/b.src": "DEF b( )\nEND\n",
        "R1/System/$config.dat": "DEFDAT $config\nINT m\nENDDAT\n",
        "R1/notes.txt": "no program",
    }.items():
        path = folder / "cell" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return folder / "cell"


def test_each_file_has_its_diagnostics_and_the_folder_its_totals(backup, lwr_dyn_command):
    code, out, err = lwr_dyn_command("krl", "check", "cell", "--json")
    record = json.loads(out)
    assert (code, err, record["holds"]) == (1, "", False)
    assert [(d["file"], d["line"], d["code"]) for d in record["diagnoses"]] == [
        ("R1/Program/a.dat", 3, "duplicate-name")
    ]
    assert [(x["file"], x["errors"]) for x in record["files"]] == [
        ("R1/Program/a.src", 0),
        ("R1/Program/a.dat", 1),
        ("R1/Program/b.src", 0),
        ("R1/System/$config.dat", 0),
    ]
    counts = {"files": 4, "lines": 13, "programs": 2, "without_error": 2, "errors": 1, "warnings": 0, "notes": 0}
    assert record["totals"] == counts
    (backup / "R1/Program/a.dat").write_text("DEFDAT a\nINT n\nENDDAT\n")
    assert lwr_dyn_command("krl", "check", "cell")[:2] == (
        0,
        "cell: no findings; 4 files, 12 lines; 2 of 2 programs without an error\n",
    )


def test_a_pipe_among_the_files_does_not_hang_the_check(backup, lwr_dyn_command):
    os.mkfifo(backup / "R1/Program/c.src")
    assert json.loads(lwr_dyn_command("krl", "check", "cell", "--json")[1])["totals"]["files"] == 4


def test_a_folder_without_programs_and_one_with_lent_files_are_refused(backup, refused):
    (backup / "none").mkdir()
    for arguments, message in (
        (("cell/none",), "cell/none: a folder without KRL files; allowed: a folder of .src, .sub and .dat files"),
        (("cell", "--with", "cell/R1/Program/a.src"), "--with: given with a folder; allowed: nothing"),
    ):
        assert message in refused("krl", "check", *arguments)
