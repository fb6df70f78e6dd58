"""GLOBAL names that two modules declare, in projects of two small modules."""

import pytest

from lwr_dyn.krl.checks.static_checks import check_project
from lwr_dyn.krl.project.program import load_project


def dat(name, line, public=" PUBLIC"):
    return f"DEFDAT {name}{public}\n{line}\nENDDAT\n"


def src(name, line):
    return f"DEF {name}( )\nEND\n{line}\nHALT\nEND\n"


LINES = ["GLOBAL INT N=1", "GLOBAL SIGNAL N $OUT[1]", "GLOBAL STRUC N INT A"]
N, HOLD = LINES[0], "GLOBAL DEF hold( )"
BOTH, LOOSE = [("error", 2), ("error", 2)], {"x/a.dat": dat("a", N), "y/b.dat": dat("b", N)}
PROJECTS = {
    **{line: ({"a.dat": dat("a", line), "b.dat": dat("b", line)}, BOTH) for line in LINES},
    "a subprogram": ({"a.src": src("a", HOLD), "b.src": src("b", HOLD.replace("h", "H"))}, [("error", 3)] * 2),
    "folders of no robot": (LOOSE, [("warning", 2)] * 2),
    "folders of one robot": ({f"R1/{name}": text for name, text in LOOSE.items()}, BOTH),
    "one is not GLOBAL": ({"a.dat": dat("a", N), "b.dat": dat("b", "INT N=1")}, []),
    "one is not PUBLIC": ({"a.dat": dat("a", N), "b.dat": dat("b", N, "")}, []),
    "one subprogram is not GLOBAL": ({"a.src": src("a", HOLD), "b.src": src("b", "DEF hold( )")}, []),
    "a copy of the module": ({"a.dat": dat("a", N), "copy/a.dat": dat("a", N)}, []),
    "two robots": ({"R1/a.dat": dat("a", N), "R2/b.dat": dat("b", N)}, []),
}


@pytest.mark.parametrize(("files", "expected"), PROJECTS.values(), ids=PROJECTS)
def test_a_global_name_of_two_modules_that_meet_is_reported_at_both(tmp_path, files, expected):
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    diagnostics = [d for x in check_project(load_project(tmp_path)) for d in x.diagnostics if d.code == "global-twice"]
    assert [(d.severity, d.position.line) for d in diagnostics] == expected
    assert len({d.position.file for d in diagnostics}) == len(expected)
