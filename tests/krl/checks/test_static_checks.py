"""Faults planted in a small project of our own, of each of 44 kinds, are told at their line and rightly named.

GLOBAL names that two modules declare, in projects of two small modules.

The count on public programs is `scripts/studies/krl_planted_faults.py`.
"""

from pathlib import Path

import pytest

from lwr_dyn.krl.checks.static_checks import check_project
from lwr_dyn.krl.project.program import load_project
from tests.krl.planting import trial
from tests.krl.planting.kinds import KINDS, REFUSED
from tests.krl.planting.site import seeded

CELL = Path(__file__).parents[1] / "planting" / "cell"
EACH = 2


@pytest.fixture(scope="module")
def modules():
    return trial.clean_modules([seeded("cell", load_project(CELL))])


@pytest.fixture(scope="module")
def found(modules):
    return trial.verdicts(modules, 29, EACH, KINDS + REFUSED)


def test_the_project_itself_is_without_diagnostics(modules):
    assert sorted(m.module.name for m in modules) == ["GRIPPER", "PALLETIZE", "WATCH"]
    assert [trial.diagnostics_of(m.of.project, m.module) for m in modules] == [(), (), ()]


@pytest.mark.parametrize("kind", KINDS + REFUSED, ids=lambda kind: kind.name)
def test_faults_of_a_kind_are_told_and_named(found, kind):
    own = [x for x in found if x.kind == kind.name]
    assert own, "none could be planted"
    assert [x for x in own if not x.named] == []


def test_the_kinds_are_different():
    assert (len(KINDS), len(REFUSED), len({kind.name for kind in KINDS + REFUSED})) == (26, 18, 44)


def test_what_is_not_told_is_counted_as_such(modules, monkeypatch):
    monkeypatch.setattr(trial, "diagnostics_of", lambda project, module: ())
    assert not any(x.told or x.named for x in trial.verdicts(modules, 29, 1))


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
