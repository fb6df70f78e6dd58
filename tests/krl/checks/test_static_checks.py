"""Faults planted in a small project of our own, of each of 44 kinds, are told at their line and rightly named.

The count on public programs is `scripts/studies/krl_planted_faults.py`.
"""

from pathlib import Path

import pytest

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
