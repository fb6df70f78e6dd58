"""GLOBAL names that two modules declare, in projects of two small modules."""

import pytest

from lwr_dyn.krl.checks.static_checks import check_project
from lwr_dyn.krl.project.program import load_project

DATA = "DEFDAT {0} PUBLIC\n{1}\nENDDAT\n"
SOURCE = "DEF {0}( )\nEND\n{1}\nHALT\nEND\n"


def found(folder, files):
    for name, text in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    diagnostics = [d for x in check_project(load_project(folder)) for d in x.diagnostics]
    return sorted((d.position.file, d.position.line, d.severity) for d in diagnostics if d.code == "global-twice")


@pytest.mark.parametrize("line", ["GLOBAL INT N=1", "GLOBAL SIGNAL N $OUT[1]", "GLOBAL STRUC N INT A"])
def test_a_global_name_of_two_public_lists_is_reported_at_both(tmp_path, line):
    files = {"a.dat": DATA.format("a", line), "b.dat": DATA.format("b", line)}
    assert found(tmp_path, files) == [("a.dat", 2, "error"), ("b.dat", 2, "error")]


def test_a_global_subprogram_of_two_modules_is_reported_at_both(tmp_path):
    files = {"a.src": SOURCE.format("a", "GLOBAL DEF hold( )"), "b.src": SOURCE.format("b", "GLOBAL DEF HOLD( )")}
    assert found(tmp_path, files) == [("a.src", 3, "error"), ("b.src", 3, "error")]


@pytest.mark.parametrize(
    "files",
    [
        {"a.dat": DATA.format("a", "GLOBAL INT N=1"), "b.dat": DATA.format("b", "INT N=1")},
        {"a.dat": DATA.format("a", "GLOBAL INT N=1"),
         "b.dat": DATA.format("b", "GLOBAL INT N=1").replace(" PUBLIC", "")},
        {"a.src": SOURCE.format("a", "GLOBAL DEF hold( )"), "b.src": SOURCE.format("b", "DEF hold( )")},
        {"a.dat": DATA.format("a", "GLOBAL INT N=1"), "copy/a.dat": DATA.format("a", "GLOBAL INT N=1")},
        {"R1/a.dat": DATA.format("a", "GLOBAL INT N=1"), "R2/b.dat": DATA.format("b", "GLOBAL INT N=1")},
    ],
)  # fmt: skip
def test_nothing_is_said_of_names_that_do_not_meet(tmp_path, files):
    assert found(tmp_path, files) == []


def test_in_folders_of_no_robot_it_is_a_warning(tmp_path):
    files = {"x/a.dat": DATA.format("a", "GLOBAL INT N=1"), "y/b.dat": DATA.format("b", "GLOBAL INT N=1")}
    assert [severity for _, _, severity in found(tmp_path, files)] == ["warning", "warning"]
    files = {f"R1/{name}": text for name, text in files.items()}
    assert [x[2] for x in found(tmp_path / "robot", files)] == ["error", "error"]
